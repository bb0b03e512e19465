"""The penalty of the fit `smooth`: what a motion is expected to be, as the spectrum of its acceleration.

A penalised fit is the best estimate of a random motion seen through white noise, whose acceleration has the spectrum

    S(f) = 1 / (1 + (f / band)^(2 slope)),       a pure power f^(-2 slope) for band = 0,

flat up to `band` and falling from there: slope 1 for accelerations that jump, 2 for jerks that jump, high for motions
with a sharp limit (a multisine). Far from the ends the fit has the gain of the Wiener filter,

    gain(f) = 1 / (1 + (f / f0)^4 S(f0) / S(f)),  f0: the half-gain frequency, where signal and noise are equal,

and band = 0 is the classical penalty on the derivative of order 2 + slope: 1 / (1 + (f / f0)^(4 + 2 slope)).

As a polynomial: x = null part + L y, with y penalised by |y|^2. For band = 0, the columns of L are the (2 + slope)-fold
integrals of orthonormal Legendre polynomials (no derivative is formed; the conditioning is that of integration), and
polynomials of degree below 2 + slope are free. Otherwise they are the twofold integrals of cosines and sines that
sample S, of Legendre coefficients (2 k + 1) i^k j_k(w) (Abramowitz & Stegun 10.1.47), and straight lines are free.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy.special

from chebid.basis import Array

_DENSITY = 2.2  # sampled frequencies per 1 / T: the process they make has the period 2.2 T


@dataclass(frozen=True)
class Spectrum:
    """S(f), f in the unit of `band` (Hz, or cycles per record)."""

    slope: int = 2
    band: float = 0.0

    @property
    def null(self) -> int:
        """Number of polynomials that are not penalised."""
        return 2 if self.band else 2 + self.slope

    def __call__(self, f: Array | float) -> Array:
        f = np.asarray(f, dtype=float)
        if not self.band:
            return f ** (-2.0 * self.slope)
        return 1 / (1 + (f / self.band) ** (2 * self.slope))

    def gain(self, f: Array | float, half: Array | float) -> Array:
        """Gain of the fit far from the ends, of half-gain frequency `half`, in the unit of f."""
        f = np.asarray(f, dtype=float)
        if not self.band:
            return 1 / (1 + (f / half) ** (4 + 2 * self.slope))
        return 1 / (1 + (f / half) ** 4 * self(half) / self(f))

    def frequency(self, gain: float, half: float) -> float:
        """The frequency at which the fit has that gain, in the unit of `half`."""
        f = half * np.geomspace(0.1, 10, 2001)
        return float(np.interp(-gain, -self.gain(f, half), f))

    def scaled(self, unit: float) -> "Spectrum":
        """The same for frequencies in multiples of `unit`."""
        return Spectrum(self.slope, self.band / unit)

    def columns(self, degree: int) -> Array:
        """L, Legendre coefficients (n + 1, F), for frequencies in cycles per record."""
        if not self.band:
            return _folded_integrals(degree, self.null)
        cycles, waves = _waves(degree)
        return waves * np.sqrt(np.tile(self(cycles), 2) / _DENSITY)

    def weight(self, half: Array | float, samples: float) -> Array:
        """Weight of |y|^2 for a half-gain frequency in cycles per record of so many steps: rate times length.

        From the power that y gives to a frequency f against that of white noise on the samples: equal at `half`.
        """
        half = np.asarray(half, dtype=float)
        if not self.band:
            order = self.null  # d^m/dt^m squared, and dt, in units of half a record
            return samples * 2 ** (2 * order - 1) * (2 * np.pi * half) ** (-2 * order)
        return samples * self(half) / (2 * (np.pi * half) ** 4)


def _integrate(columns: Array, times: int) -> Array:
    """Legendre coefficients of repeated integrals, from (2 j + 1) P_j = P'_{j+1} - P'_{j-1} (A & S 8.5.4).

    Constants of integration are polynomials that are free; what goes beyond the highest degree is dropped.
    """
    odd = (2 * np.arange(float(len(columns))) + 1)[:, None]
    for _ in range(times):
        scaled = columns / odd
        columns = np.zeros_like(scaled)
        columns[1:] += scaled[:-1]
        columns[:-1] -= scaled[1:]
    return columns


@lru_cache(maxsize=8)
def _folded_integrals(degree: int, times: int) -> Array:
    """`times`-fold integrals (n + 1, n + 1 - times) of orthonormal p_0, p_1 ..."""
    unit = np.sqrt((2 * np.arange(degree + 1.0) + 1) / 2)
    return _integrate(np.diag(unit)[:, : max(degree + 1 - times, 0)], times)


@lru_cache(maxsize=8)
def _waves(degree: int) -> tuple[Array, Array]:
    """Frequencies (F,) in cycles per record, and twofold integrals (n + 1, 2 F) of their cosines and sines."""
    highest = _resolved(degree) / np.pi
    count = max(1, int(_DENSITY * highest + 0.5))
    cycles = (np.arange(count) + 0.5) / _DENSITY
    k = np.arange(degree + 3)[:, None]
    bessel = (2 * k + 1) * scipy.special.spherical_jn(k, np.pi * cycles) * np.where(k // 2 % 2 == 0, 1, -1)
    waves = np.hstack([np.where(k % 2 == 0, bessel, 0), np.where(k % 2 == 1, bessel, 0)])
    return cycles.astype(float), _integrate(waves, 2)[: degree + 1]


def _resolved(degree: int) -> float:
    """The highest w = pi f T that so many polynomials resolve to 1e-4: n = w + 2 w^(1/3), by Cardano's formula."""
    return float((np.sqrt(8 / 3) * np.sinh(np.arcsinh(0.75 * degree * np.sqrt(1.5)) / 3)) ** 3)
