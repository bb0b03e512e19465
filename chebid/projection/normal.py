"""Least squares on Chebyshev polynomials (eq. 11) by the fast normal equations, safe up to n = 4 sqrt(N)."""

import numpy as np
import scipy.linalg

from chebid.basis import Array
from chebid.projection.sums import normal_blocks


def least_squares(tau: Array, x: Array, degree: int) -> Array:
    """Chebyshev coefficients (n + 1, J) of samples x (N, J) at tau (N,)."""
    out = np.zeros((degree + 1, x.shape[1]))
    for where, matrix, moments in normal_blocks(tau, x, degree):
        out[where] = scipy.linalg.cho_solve(scipy.linalg.cho_factor(matrix), moments)
    return out
