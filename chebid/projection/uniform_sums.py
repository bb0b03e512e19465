"""Sums of Chebyshev polynomials over a uniform grid, most samples of which need not be looked at.

Where T_m turns little from one sample to the next, the sum over the samples is the integral and its Euler-Maclaurin
correction (Abramowitz & Stegun 23.1.30), at tau = -a and a, to the order h^8. Only the samples beyond a are summed.
"""

import numpy as np

from chebid.basis import Array
from chebid.projection.fold import symmetric_grid
from chebid.projection.sums import circle, real_sums

_TURN = 0.1  # rad from sample to sample: (0.1 / 2 pi)^10 is below rounding
_EULER_MACLAURIN = (1 / 12, -1 / 720, 1 / 30240, -1 / 1209600)  # B_2j / (2 j)!


def uniform_sums(samples: int, highest: int) -> Array:
    """S_m = sum_k T_m(tau_k), m = 0, 2, .. `highest` (even), over the symmetric uniform grid of N samples."""
    step, tau = 2 / (samples - 1), symmetric_grid(samples)
    # m times the angle between samples, h / sin(theta), is small from here on
    outer = max(1, int(np.searchsorted(circle(tau[: samples // 2]).imag, highest * step / _TURN)))
    if 2 * outer > samples - 8:
        return _direct(tau, highest)
    return 2 * _direct(tau[:outer], highest) + _inner(-float(tau[outer]), step, np.arange(0.0, highest + 1, 2))


def _direct(tau: Array, highest: int) -> Array:
    return real_sums(circle(tau) ** 2, [np.ones((len(tau), 1))], highest // 2)[0][:, 0]


def _inner(a: float, step: float, m: Array) -> Array:
    """Sum over the grid points from -a to a."""
    theta = np.arccos(a)
    cosine, sine = np.cos(m * theta), np.sin(m * theta)
    # T_m = cos(m theta) and its integral, from the ones of degree m + 1 and m - 1
    above = (cosine * a - sine * np.sin(theta)) / (m + 1)
    below = (cosine * a + sine * np.sin(theta)) / (m - 1)
    out = (above - below) / step + cosine
    low, high = cosine, m * sine / np.sin(theta)  # derivatives of order j and j + 1
    for j, factor in enumerate(_EULER_MACLAURIN):
        out += 2 * factor * step ** (2 * j + 1) * high
        for order in (2 * j, 2 * j + 1):  # (1 - a^2) f'' = a f' - m^2 f, differentiated
            low, high = high, ((2 * order + 1) * a * high + (order**2 - m**2) * low) / (1 - a**2)
    return out
