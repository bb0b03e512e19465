"""The clock of a log: which samples have a usable stamp, and where the recording was interrupted."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.log.findings import Findings

_GAP = 5.0  # median steps that a gap is longer than


@dataclass(frozen=True)
class Clock:
    """Stamps `t` (n,) of the samples `keep` (n,) of the file, and the places in `t` where a new record begins."""

    t: NDArray[np.float64]
    keep: NDArray[np.int64]
    cuts: tuple[int, ...]


def even_clock(count: int, rate: float) -> Clock:
    """The clock of a log without a time column: sample k at k / rate."""
    return Clock(np.arange(count) / rate, np.arange(count), ())


def read_clock(stamps: NDArray[np.float64], name: str, rows: NDArray[np.int64], findings: Findings) -> Clock:
    """Check the stamps (N,) of the column `name`. Raises InputError when they are no clock."""
    keep = np.flatnonzero(np.isfinite(stamps))
    t = stamps[keep]
    step = np.diff(t)
    forward = step[step > 0]
    if len(forward) == 0:
        raise findings.error("the time never advances", "name the time column", column=name, row=rows[0])
    usual = float(np.median(forward))
    cuts = np.flatnonzero((step <= 0) | (step > _GAP * usual)) + 1
    for cut in cuts:
        kind = "gap" if step[cut - 1] > 0 else "time_back"
        message = f"steps by {step[cut - 1]:.6g} s: a new record begins"
        findings.note(kind, message, column=name, row=rows[keep[cut]], value=t[cut])
    return Clock(t, keep, tuple(int(cut) for cut in cuts))
