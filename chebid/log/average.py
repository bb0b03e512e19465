"""Torques that were logged as a mean over an interval, as they were at its middle.

A mean over L s loses (2 pi f L)^2 / 24 of what has the frequency f. That is little (0.04 % at 1.6 Hz and L = 10 ms),
but the same in every sample, and after 20 s of motion more than the deviation of an inertia. The means L s before and
after tell how much it is (as cell averages become point values in finite volumes):

    tau(t) = m(t) - (m(t + L) - 2 m(t) + m(t - L)) / 24,   right to (2 pi f L)^4 / 200.
"""

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Place

Array = NDArray[np.float64]


def at_instants(t: Array, means: Array, interval: float) -> Array:
    """Torques (N, J) at t (N,) s of their means over `interval` s centred there.

    A sample that lacks a neighbour stays as it is. Raises InputError for an interval below zero.
    """
    if interval < 0:
        raise InputError(
            "is below zero",
            hint="give seconds, or leave it out",
            place=Place(key="log: torque_average", value=interval),
        )
    if interval == 0:
        return means
    before, after = (np.column_stack([np.interp(at, t, one) for one in means.T]) for at in (t - interval, t + interval))
    change = (after - 2 * means + before) / 24
    step = 1e-6 * float(np.median(np.diff(t)))  # stamps are rounded
    change[(t - interval < t[0] - step) | (t + interval > t[-1] + step)] = 0.0
    return means - np.where(np.isfinite(change), change, 0.0)
