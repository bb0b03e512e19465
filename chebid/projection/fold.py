"""Samples on a grid symmetric about 0 fall into an even and an odd half, and so do polynomials: a quarter of the work.

`Fold` is an orthonormal change of coordinates: e_k = (x_k + x_{N-1-k}) / sqrt 2, o_k = (x_k - x_{N-1-k}) / sqrt 2, and
the middle sample for itself. Even polynomials live in the one, odd ones in the other. Other grids have one fold.
"""

from dataclasses import dataclass

import numpy as np

from chebid.basis import Array, Family


@dataclass(frozen=True)
class Fold:
    """One half of the samples, `parity` 0 or 1, or all of them (None)."""

    parity: int | None = None

    def degrees(self, degree: int) -> slice:
        """Which of the coefficients c_0 .. c_n live here."""
        return slice(None, degree + 1) if self.parity is None else slice(self.parity, degree + 1, 2)

    def samples(self, x: Array) -> Array:
        """Coordinates (..., H) of samples x (..., N)."""
        if self.parity is None:
            return x
        half, middle = divmod(x.shape[-1], 2)
        turned = x[..., ::-1]
        if self.parity:
            return (x[..., :half] - turned[..., :half]) * np.sqrt(0.5)
        out = x[..., : half + middle] + turned[..., : half + middle]
        out *= np.sqrt(0.5)
        out[..., half:] *= np.sqrt(0.5)
        return out

    def rows(self, samples: int) -> int:
        """Number H of coordinates of N samples."""
        return samples if self.parity is None else (samples + 1 - self.parity) // 2

    def polynomials(self, family: Family, tau: Array, degree: int, rows: slice = slice(None)) -> Array:
        """Coordinates (H, n_b) of the polynomials that live here, at tau (N,); or some rows of them."""
        if self.parity is None:
            return family.values(tau[rows], degree)
        half, left = len(tau) // 2, tau[: self.rows(len(tau))][rows]
        out = family.values(left, degree)[:, self.degrees(degree)]
        # a row stands for two samples, or for the one in the middle
        out = out * np.where(np.arange(len(tau))[: self.rows(len(tau))][rows] < half, np.sqrt(2), 1.0)[:, None]
        return out


WHOLE = (Fold(),)
HALVES = (Fold(0), Fold(1))


def folds(tau: Array) -> tuple[Fold, ...]:
    """The folds of the grid tau (N,)."""
    return HALVES if np.array_equal(tau, -tau[::-1]) else WHOLE


def symmetric_grid(samples: int) -> Array:
    """Uniform on [-1, 1], symmetric to the last bit."""
    grid = np.linspace(-1.0, 1.0, samples)
    return (grid - grid[::-1]) / 2
