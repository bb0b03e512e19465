"""Torques for the browser: samples of the log as they are, fewer where there are too many, packed in base64."""

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.motion import Mask, Track

BUDGET = 2_200_000  # characters of all curves of a page
_PER_SAMPLE = (8 + 4 + 4) * 4 / 3  # characters: t, measured, predicted
_FEWEST = 200  # samples of a curve
_SHORT = 2e-3  # of the whole time: stretches and pauses that no picture shows
_APART = 0.02  # of the whole time, between records whose clocks overlap


def most_samples(curves: int) -> int:
    """How many samples of each of so many curves fit on a page."""
    return max(_FEWEST, int(BUDGET / _PER_SAMPLE / max(curves, 1)))


def thin(columns: Sequence[Array], most: int) -> NDArray[np.int64]:
    """Which of N samples to keep, some `most` at the most: of equal runs the least and largest of each column (N,)."""
    count = len(columns[0])
    if count <= most:
        return np.arange(count)
    length = -(-count // max(1, (most - 2) // (2 * len(columns))))
    kept = [np.array([0, count - 1])]
    for values in columns:
        runs = np.concatenate([values, np.full(-count % length, np.nan)]).reshape(-1, length)
        gaps, start = np.isnan(runs), length * np.arange(len(runs))
        kept += [
            start + np.where(gaps, np.inf, runs).argmin(axis=1),
            start + np.where(gaps, -np.inf, runs).argmax(axis=1),
        ]
    return np.unique(np.minimum(np.concatenate(kept), count - 1))


def curve(
    tracks: Sequence[Track], torques: Sequence[Array], used: Sequence[Mask], joint: int, most: int
) -> dict[str, Any]:
    """Measured and predicted torque of a joint, as `page.js` reads it.

    `t` s as drawn (double), `measured`, `predicted` (single precision): base64, little-endian, NaN between records;
    `records`: first index of each and what was added to its clock; `unused`: stretches of samples that are not
    `used` (N, J).
    """
    total = sum(len(track.motion.t) for track in tracks)
    parts: list[tuple[Array, Array, Array]] = []
    records, unused, at, free = [], [], 0, -np.inf
    span = sum(float(track.motion.t[-1] - track.motion.t[0]) for track in tracks)
    for track, torque, good in zip(tracks, torques, used, strict=True):
        measured, predicted, t = track.torque[:, joint], torque[:, joint], track.motion.t
        offset = 0.0 if t[0] > free else float(free + _APART * span - t[0])
        kept = thin([measured, measured - predicted], max(8, most * len(t) // total))
        parts += [(t[kept] + offset, measured[kept], predicted[kept]), (t[-1:] + offset, _GAP, _GAP)]
        records.append([at, offset])
        unused += stretches(t + offset, ~good[:, joint])
        at, free = at + len(kept) + 1, float(t[-1]) + offset
    t, measured, predicted = (np.concatenate(column)[:-1] for column in zip(*parts, strict=True))
    return {
        "t": _packed(t, "<f8"),
        "measured": _packed(measured, "<f4"),
        "predicted": _packed(predicted, "<f4"),
        "records": records,
        "unused": unused,
        "thinned": len(t) < total,
    }


_GAP = np.array([np.nan])


def stretches(t: Array, which: Mask) -> list[list[float]]:
    """Begin and end, s, of the stretches of samples (N,) that are marked; near ones are joined, short ones left out."""
    short = _SHORT * float(t[-1] - t[0])
    edges = np.flatnonzero(np.diff(np.concatenate([[0], which.astype(int), [0]]))).reshape(-1, 2)
    out: list[list[float]] = []
    for begin, end in ((float(t[a]), float(t[min(b, len(t) - 1)])) for a, b in edges):
        if out and begin - out[-1][1] < short:
            out[-1][1] = end
        else:
            out.append([begin, end])
    return [[a, b] for a, b in out if b - a >= short]


def _packed(values: Array, kind: str) -> str:
    return base64.b64encode(values.astype(kind).tobytes()).decode()
