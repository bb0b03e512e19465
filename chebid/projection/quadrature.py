"""Projection by the weighted inner product (eq. 9), exact for signals linear between samples (annex 5.1).

Regrouped on the jumps of slope: with x'' = sum_j (s_j - s_{j-1}) delta(tau - tau_j), integrating <x, T_i> by parts
twice leaves one sine sum per degree instead of the N (n + 1) integrals I_ij and J_ij. With theta = arccos tau, from the
left end (theta = pi) to the right one (theta = 0), and slopes s_j = dx/dtau,

    <x, T_i> = (1/i) sum_j s_j [G_i(theta_j) - G_i(theta_{j+1})],      i >= 1
    G_i(theta) = int sin(i u) sin(u) du = (sin((i-1) theta) / (i-1) - sin((i+1) theta) / (i+1)) / 2,
    G_1(theta) = theta / 2 - sin(2 theta) / 4,

which is the annex with its J_ij for i >= 2 corrected (the printed one lacks the i inside the second sine).
Chebyshev II follows from <x, U_i>_II = (<x, T_i> - <x, T_{i+2}>) / 2; Legendre from
(2 i + 1) P_i = P'_{i+1} - P'_{i-1}, twice.
"""

import numpy as np

from chebid.basis import CHEBYSHEV, CHEBYSHEV2, LEGENDRE, Array, Family
from chebid.projection.sums import circle, real_sums


def quadrature_coefficients(tau: Array, x: Array, degree: int, family: Family = CHEBYSHEV) -> Array:
    """Coefficients (n + 1, J) of eq. 9 for x (N, J) at tau (N,) increasing, held constant beyond the first and last."""
    index = np.arange(degree + 1.0)
    if family is LEGENDRE:
        products = _legendre_products(tau, x, degree)
    elif family is CHEBYSHEV2:
        first = _chebyshev_products(tau, x, degree + 2)
        products = (first[:-2] - first[2:]) / 2
    else:
        products = _chebyshev_products(tau, x, degree)
    return products / family.norms(index)[:, None]


def _slope_jumps(tau: Array, x: Array) -> Array:
    """Jumps of slope (N, J) at the samples, the slope outside the record being zero."""
    slopes = np.diff(x, axis=0) / np.diff(tau)[:, None]
    return np.diff(slopes, axis=0, prepend=0.0, append=0.0)


def _chebyshev_products(tau: Array, x: Array, degree: int) -> Array:
    """<x, T_i>, i = 0 .. n: (n + 1, J)."""
    z, jumps = circle(tau), _slope_jumps(tau, x)
    theta = np.angle(z)
    sines = real_sums(z, [(-1j * jumps).astype(complex)], degree + 1)[0]  # sum_j jump_j sin(m theta_j)
    out = np.empty((degree + 1, x.shape[1]))
    # i = 0: x dtheta over each segment, by parts: x theta at the ends and the slopes times sin
    out[0] = np.pi * x[0] + jumps.T @ (np.sin(theta) - theta * np.cos(theta))
    if degree >= 1:
        out[1] = jumps.T @ (theta / 2) - sines[2] / 4
    i = np.arange(2.0, degree + 1)[:, None]
    out[2:] = (sines[1:degree] / (i - 1) - sines[3:] / (i + 1)) / (2 * i)
    return out


def _legendre_products(tau: Array, x: Array, degree: int) -> Array:
    """Integrals of x P_i: x'' against the double integral of P_i that vanishes with its slope at both ends (i >= 2)."""
    jumps = _slope_jumps(tau, x)
    index = np.arange(degree + 3.0)
    moments = np.zeros((degree + 3, x.shape[1]))
    for start in range(0, len(tau), 4096):
        piece = slice(start, start + 4096)
        moments += LEGENDRE.values(tau[piece], degree + 2).T @ jumps[piece]
    out = np.empty((degree + 1, x.shape[1]))
    right = 1 - tau[:, None]
    out[0] = 2 * x[0] + np.sum(jumps * right**2 / 2, axis=0)
    if degree >= 1:
        out[1] = np.sum(jumps * (right**2 / 2 - right**3 / 6), axis=0)
    i = index[2 : degree + 1, None]
    low, mid, high = (moments[: degree - 1], moments[2 : degree + 1], moments[4 : degree + 3])
    out[2:] = (low / (2 * i - 1) - mid * (1 / (2 * i - 1) + 1 / (2 * i + 3)) + high / (2 * i + 3)) / (2 * i + 1)
    return out
