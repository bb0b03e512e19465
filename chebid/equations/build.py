"""Equations by projection: the whole system of equations, not only q, is projected (abstract of the paper).

The rows are the coefficients of both sides of every joint's equation on the test functions of `functions.py`. What
lies above the band is gone from both sides alike, which repairs a degree too low for q.
"""

from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.equations.functions import moving_functions
from chebid.equations.gate import moving
from chebid.equations.rows import JointNoise, Rows, merge
from chebid.errors import NoAnswerError
from chebid.motion import Track
from chebid.projection.quality import TOLERATED_SHARE

_FLAT = 0.6  # of the bandwidth of a joint that is not passed whole: up to there its accelerations are right to 1 %
_CHUNK = 32768  # samples whose regressor is held at a time
_ENERGY = 0.999  # of the model's torque lies inside the band that is chosen


@dataclass(frozen=True)
class Band:
    """Band of the equations: Hz, and why."""

    frequency: float
    reason: str


def widest_band(tracks: list[Track]) -> float:
    """Hz up to which the regressors of all tracks can be trusted."""
    return min(min(_trusted(track), 0.4 * track.rate) for track in tracks)


def _trusted(track: Track) -> float:
    """Where every joint is passed whole, the bandwidth of the fastest: the others have nothing to say up there."""
    losing = [p.plan.bandwidth for p in track.projections if p.energy_left_out > TOLERATED_SHARE]
    return _FLAT * min(losing) if losing else max(p.plan.bandwidth for p in track.projections)


def choose_band(tracks: list[Track], dynamics: Dynamics, theta: Array) -> Band:
    """The band that holds 99.9 % of the energy of the torque of a first model, `theta` (P,), on every joint."""
    most = widest_band(tracks)
    found = max(_energy_band(track, dynamics, theta) for track in tracks)
    if found < most:
        return Band(found, f"holds {100 * _ENERGY:.1f} % of the energy of the model's torque")
    return Band(most, "all that the projections of the positions pass")


def _energy_band(track: Track, dynamics: Dynamics, theta: Array) -> float:
    torque = np.where(track.valid[:, None], dynamics.torque(track.motion, theta), 0.0)
    power = np.abs(np.fft.rfft(torque * np.hanning(len(torque))[:, None], axis=0)) ** 2
    share = np.cumsum(power, axis=0) / np.maximum(power.sum(axis=0), np.finfo(float).tiny)
    index = max(int(np.searchsorted(share[:, j], _ENERGY)) for j in range(torque.shape[1]))
    return max(index, 4) * track.rate / len(torque)


def measured_rows(tracks: list[Track], dynamics: Dynamics, gate: Array, band: float) -> Rows:
    """Rows of all tracks, band in Hz. Raises NoAnswerError when the gate and the trim leave nothing."""
    rows = merge([_track_rows(track, dynamics, gate, band) for track in tracks])
    for j, noise in enumerate(rows.noise):
        if noise.samples == 0:
            raise NoAnswerError(
                f"joint {dynamics.joints[j]} is slower than its gate of {gate[j]:.3g} everywhere: no sample is left",
                hint="record a motion of this joint, or lower processing: velocity_gate",
            )
        if noise.equations == 0:
            raise NoAnswerError(
                f"joint {dynamics.joints[j]} moves in stretches too short for a band of {band:.3g} Hz",
                hint="raise the bandwidth, or leave it out and chebid chooses it",
            )
    return rows


def _track_rows(track: Track, dynamics: Dynamics, gate: Array, band: float) -> Rows:
    used = moving(track, gate)
    joints, width = used.shape[1], len(dynamics.parameters) + 1
    grams = np.zeros((joints, width, width))
    parts: list[tuple[int, list[Array]]] = []
    chunk = _Chunk(track, dynamics)
    for functions in moving_functions(track, used, track.valid, band):
        system, piece = chunk.system(functions.piece), functions.piece
        for j in range(joints):
            mine = system[used[piece][:, j], j]
            grams[j] += mine.T @ mine
        parts.append((functions.number, functions.rows(system)))
    return _collect(parts, band, grams, used.sum(axis=0))


def project_columns(track: Track, gate: Array, band: float, columns: Array) -> Array:
    """Further columns (N, J, K), known at the samples of a track, as rows (R, K) in the order of `measured_rows`."""
    used = moving(track, gate)
    parts = [f.rows(columns[f.piece]) for f in moving_functions(track, used, track.valid, band)]
    return np.concatenate([part[j] for j in range(used.shape[1]) for part in parts])


class _Chunk:
    """[W Y] at the samples (N, J, P + 1) of a track, made a chunk at a time and never whole."""

    def __init__(self, track: Track, dynamics: Dynamics) -> None:
        self._track, self._dynamics = track, dynamics
        self._start, self._values = 0, np.zeros((0, 0, 0))

    def system(self, piece: slice) -> Array:
        """Rows of a stretch; stretches are asked for in order."""
        if piece.stop > self._start + len(self._values):
            self._start = piece.start
            ahead = slice(piece.start, max(piece.stop, piece.start + _CHUNK))
            regressor = self._dynamics.regressor(self._track.motion.cut(ahead))
            self._values = np.concatenate([regressor, self._track.torque[ahead][:, :, None]], axis=2)
        return self._values[piece.start - self._start : piece.stop - self._start]


def _collect(parts: list[tuple[int, list[Array]]], band: float, grams: Array, samples: Array) -> Rows:
    """Rows joint by joint, and within a joint in order of time."""
    joints, width = grams.shape[:2]
    own = [[(number, part[j]) for number, part in parts] for j in range(joints)]
    system = np.concatenate([np.zeros((0, width)), *(part for mine in own for _, part in mine)])
    counts = np.array([sum(len(part) for _, part in mine) for mine in own], dtype=int)
    return Rows(
        W=system[:, :-1],
        Y=system[:, -1],
        joint=np.repeat(np.arange(joints), counts),
        # the k-th of functions that live in a time T has the frequency k / (2 T): they share out the band
        frequency=_joined([band * np.arange(1, len(part) + 1) / len(part) for mine in own for _, part in mine]),
        block=_joined([np.full(len(part), number) for mine in own for number, part in mine]).astype(int),
        noise=tuple(JointNoise(grams[j], int(samples[j]), float(counts[j])) for j in range(joints)),
    )


def _joined(parts: list[Array]) -> Array:
    return np.concatenate([np.zeros(0), *parts])
