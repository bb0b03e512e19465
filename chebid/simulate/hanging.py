"""A link that hangs on its motor by a spring or in a gap: the march of its lag delta(t), compiled.

    M(t) delta'' + f(delta, delta') = tau(t),   f = K delta + D delta' beyond +-gap/2, nothing within

by steps of semi-implicit Euler. numba is loaded with this module, and compiles it once.
"""

import numpy as np
from numba import int64, njit, types

from chebid.simulate.compiling import matrix, vector

_MARCH = types.void(vector, vector, vector, vector, vector, vector, int64, matrix, matrix)


@njit(_MARCH, cache=True, error_model="numpy")
def march(t, inertia, torque, stiffness, damping, gap, steps, force, bend):  # type: ignore[no-untyped-def]
    """Fill force and bend (N, K): f and delta'' at every instant t (N,), `steps` steps to each interval.

    inertia M, torque tau (N,); stiffness K, damping D, gap (K,). The link starts wound up, so that it does not ring.
    """
    for k in range(len(gap)):
        half = gap[k] / 2
        delta, speed = torque[0] / stiffness[k] + np.sign(torque[0]) * half, 0.0
        for i in range(len(t)):
            last = i == len(t) - 1
            for step in range(1 if last else steps):
                share = step / steps
                M = inertia[i] if last else inertia[i] + share * (inertia[i + 1] - inertia[i])
                tau = torque[i] if last else torque[i] + share * (torque[i + 1] - torque[i])
                beyond = delta - min(max(delta, -half), half)
                f = stiffness[k] * beyond + damping[k] * speed if half == 0.0 or beyond != 0.0 else 0.0
                acceleration = (tau - f) / M
                if step == 0:
                    force[i, k], bend[i, k] = f, acceleration
                if not last:
                    h = (t[i + 1] - t[i]) / steps
                    speed += h * acceleration
                    delta += h * speed
