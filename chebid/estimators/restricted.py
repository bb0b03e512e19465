"""Variance of noise as a function of frequency, by restricted maximum likelihood: for the weights of a test.

log v(f) is the polynomial of `spectrum`. Restricted likelihood (Patterson and Thompson, Biometrika 58, 1971) counts off
what the parameters have taken from the residual, frequency by frequency. It is sharper than squares of a residual of
ordinary least squares, and right only where the model is: a test of the model may assume that, a deviation may not.
"""

import numpy as np

from chebid.basis import Array
from chebid.estimators.spectrum import DEGREE, ROWS, rooted

_ROUNDS = 30
_TINY = np.finfo(float).tiny


def restricted_variance(X: Array, y: Array, frequency: Array) -> Array:
    """Variances v (R,) of the noise of y = X theta + noise, X (R, P), at `frequency` (R,); all rows of one joint."""
    X = X[:, np.any(X != 0, axis=0)]
    x = rooted(frequency)
    best, least = np.full(len(y), max(float(np.mean(y**2)), _TINY)), np.inf
    for degree in range(DEGREE + 1):
        if degree and (len(y) - X.shape[1] < ROWS * (degree + 1) or np.ptp(x) == 0):
            break
        B = np.asarray(np.polynomial.legendre.legvander(x, degree), dtype=np.float64)
        variance, likelihood = _fit(X, y, B)
        if degree + 1 - likelihood < least:
            best, least = variance, degree + 1 - likelihood
    return best


def _fit(X: Array, y: Array, B: Array) -> tuple[Array, float]:
    """v = exp(B phi) (R,) of the largest restricted likelihood, and its logarithm (Fisher scoring)."""
    left = max(len(y) - X.shape[1], 1)
    residual = y - X @ np.linalg.lstsq(X, y)[0]
    phi = np.zeros(B.shape[1])
    phi[0] = np.log(max(float(residual @ residual) / left, _TINY))
    information = np.linalg.inv(B.T @ B)
    for _ in range(_ROUNDS):
        squares, leverage, _ = _generalised(X, y, np.exp(B @ phi))
        step = information @ (B.T @ (squares - (1 - leverage)))
        phi = phi + np.clip(step, -1, 1)
        if np.max(np.abs(step)) < 1e-4:
            break
    variance = np.exp(B @ phi)
    squares, _, logarithm = _generalised(X, y, variance)
    return variance, -0.5 * float(np.sum(np.log(variance)) + logarithm + np.sum(squares))


def _generalised(X: Array, y: Array, variance: Array) -> tuple[Array, Array, float]:
    """Least squares with these variances: squared whitened residuals, leverages (R,), log det X^T V^-1 X."""
    root = np.sqrt(variance)
    q, r = np.linalg.qr(X / root[:, None])
    whitened = y / root - q @ (q.T @ (y / root))
    diagonal = np.maximum(np.abs(np.diag(r)), _TINY)
    return whitened**2, np.sum(q**2, axis=1), float(2 * np.sum(np.log(diagonal)))
