"""Time stamps: their rate, and whether they are a uniform grid."""

import numpy as np

from chebid.basis import Array

_UNEVEN = 1e-4  # steps: stamps nearer than this to a uniform grid are uniform, 100 ns at 1 kHz
_DIGITS = 2  # that rounding may be off: stamps since 1970 have 240 ns


def rate_of(t: Array) -> float:
    """Mean rate in Hz of stamps t (N,) s."""
    return (len(t) - 1) / float(t[-1] - t[0])


def is_uniform(t: Array) -> bool:
    """Whether the stamps are a uniform grid: to a ten-thousandth of a step, or to their last digits."""
    grid = np.linspace(t[0], t[-1], len(t))
    grid -= t
    digit = float(np.spacing(max(abs(t[0]), abs(t[-1]))))
    return bool(max(grid.max(), -grid.min()) <= max(_UNEVEN / rate_of(t), min(_DIGITS * digit, 0.01 / rate_of(t))))
