"""Time stamps: their rate, and whether they are a uniform grid."""

import numpy as np

from chebid.basis import Array

_UNEVEN = 1e-4  # steps: stamps nearer than this to a uniform grid are uniform, 100 ns at 1 kHz


def rate_of(t: Array) -> float:
    """Mean rate in Hz of stamps t (N,) s."""
    return (len(t) - 1) / float(t[-1] - t[0])


def is_uniform(t: Array) -> bool:
    """Whether the stamps are a uniform grid, to a ten-thousandth of a step."""
    grid = np.linspace(t[0], t[-1], len(t))
    grid -= t
    return bool(max(grid.max(), -grid.min()) <= _UNEVEN / rate_of(t))
