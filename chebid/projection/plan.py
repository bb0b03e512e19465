"""`Plan`: what an operator is to do, in numbers that do not depend on the record."""

from dataclasses import dataclass

import numpy as np

from chebid.projection.spectrum import Spectrum

FITS = ("lsq", "quadrature", "smooth")


@dataclass(frozen=True)
class Plan:
    """What an operator is to do. `window` s (None: the whole record), `penalty` Hz: half-gain frequency of the penalty.

    `bandwidth` Hz is the frequency up to which the plan lets signals pass: n / (pi T) for one least-squares window, in
    its middle (facts: n_c = pi f T polynomials resolve a sine), and the -3 dB point of a penalty.
    `slope` and `band` (Hz) shape the penalty: see `Spectrum`; as they stand, it is on the fourth derivative.
    """

    fit: str = "lsq"
    basis: str = "chebyshev"
    degree: int = 0
    window: float | None = None
    penalty: float = np.inf
    bandwidth: float = 0.0
    reason: str = ""
    slope: int = 2
    band: float = 0.0

    @property
    def spectrum(self) -> Spectrum:
        return Spectrum(self.slope, self.band)


def limit(fit: str, samples: int) -> int:
    """Highest degree for so many samples.

    4 sqrt(N) for the projections of the paper (beyond, the ends explode); for the penalised one a tenth more than the
    (pi / 2) N that resolve half the sampling rate.
    """
    if fit == "smooth":
        return max(4, int(1.1 * np.pi / 2 * (samples - 1)))
    return max(0, min(samples - 1, int(4 * np.sqrt(samples))))
