"""What a log is once it is read: records on their own clocks."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from chebid.errors import Notice

Gain = float | tuple[float, ...] | tuple[tuple[float, ...], ...]


@dataclass(frozen=True)
class LogSpec:
    """How the logs of one robot are read: the `log:` section of the model file.

    `rate` in Hz for logs without a time column; gains in rad (or m) and N.m (or N) per logged unit: a number, one per
    joint, or a matrix (joints, columns); `torque_delay` in s by which the torque column lags the position column;
    `torque_average` in s over which each torque is a mean, centred on its stamp.
    """

    time: str | None = None
    rate: float | None = None
    position: tuple[str, ...] | None = None
    torque: tuple[str, ...] | None = None
    reference: tuple[str, ...] | None = None
    position_gain: Gain = 1.0
    position_offset: float | tuple[float, ...] = 0.0
    torque_gain: Gain = 1.0
    torque_delay: float = 0.0
    torque_average: float = 0.0


@dataclass(frozen=True)
class Record:
    """One uninterrupted stretch of a log, in SI units.

    `t` (N,) s, strictly increasing, the log's own stamps; `q` (N, J) rad or m; `tau` (N, J) N.m or N, or None;
    `reference` (N, J) or None; `rows` (N,) row numbers in the file. NaN marks a sample that is missing or was left
    out, each named in a notice of the log.
    """

    t: NDArray[np.float64]
    q: NDArray[np.float64]
    tau: NDArray[np.float64] | None
    reference: NDArray[np.float64] | None
    rows: NDArray[np.int64]

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return float(self.t[-1] - self.t[0])

    @cached_property
    def rate(self) -> float:
        """Usual rate, Hz: the inverse of the median step."""
        return 1.0 / float(np.median(np.diff(self.t)))

    @cached_property
    def uniform(self) -> bool:
        """Whether all steps are equal within the resolution of the stamps."""
        return is_uniform(self.t)


@dataclass(frozen=True)
class Log:
    """A log file: its records, the names of its joints (or signals), and what was found odd in it."""

    path: Path
    sha256: str
    names: tuple[str, ...]
    records: tuple[Record, ...]
    notices: tuple[Notice, ...]


def is_uniform(t: NDArray[np.float64]) -> bool:
    """Whether stamps (N,) lie on an even grid: within their resolution, if below 1 % of a step, or 0.02 % of a step."""
    if len(t) < 3:
        return True
    step = (t[-1] - t[0]) / (len(t) - 1)
    off = np.abs(t - (t[0] + step * np.arange(len(t)))).max()
    return bool(off <= 2e-4 * step or (off <= 1e-2 * step and off <= stamp_resolution(t)))


def is_single(x: NDArray[np.float64]) -> bool:
    """Whether all values were single precision once; False beyond its range."""
    with np.errstate(over="ignore"):
        return bool(np.array_equal(x.astype(np.float32).astype(np.float64), x))


def stamp_resolution(t: NDArray[np.float64]) -> float:
    """The step in which stamps (s) are written: a power of ten, or that of single or double precision."""
    largest = float(np.abs(t).max())
    double = 4 * float(np.finfo(np.float64).eps) * largest
    if is_single(t):
        return max(double, float(np.finfo(np.float32).eps) * largest)
    for digits in range(10):
        grid = t * 10.0**digits
        if np.abs(grid - np.rint(grid)).max() <= 1e-6 + double * 10.0**digits:
            return max(double, 10.0**-digits)
    return double
