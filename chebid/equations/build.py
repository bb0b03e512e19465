"""Equations by projection: the whole system of equations, not only q, is projected (abstract of the paper).

On equal stretches of time both sides of every joint's equation are multiplied by the gate (0 or 1: what is wrong at
slow speed stays out of the projection) and expanded in polynomials orthonormal on the samples: the coefficients are
the rows. White noise on the torque stays white on the coefficients, there are as many as there are independent
equations (so that eq. 26 is honest), and what lies above the band is gone from both sides alike, which repairs a
degree too low for q.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.effects import Motion
from chebid.equations.gate import moving
from chebid.equations.rows import JointNoise, Rows, merge
from chebid.errors import NoAnswerError
from chebid.motion import Mask, Track
from chebid.projection.modes import degree_modes

_SHARP = 2.5  # n <= 2.5 sqrt(N) on a stretch: its polynomials stay well conditioned
_LONGEST = 150  # degree on a stretch: more would only cost time
_FLAT = 0.6  # of the bandwidth of q: up to there its accelerations are right to 1 %
_CHUNK = 32768  # samples whose regressor is held at a time
_ENERGY = 0.999  # of the model's torque lies inside the band that is chosen


@dataclass(frozen=True)
class Band:
    """Band of the equations: Hz, and why."""

    frequency: float
    reason: str


def widest_band(tracks: list[Track]) -> float:
    """Hz up to which the accelerations of all tracks can be trusted."""
    return min(min(_FLAT * track.bandwidth, 0.4 * track.rate) for track in tracks)


def choose_band(tracks: list[Track], dynamics: Dynamics, theta: Array) -> Band:
    """The band that holds 99.9 % of the energy of the torque of a first model, `theta` (P,), on every joint."""
    most = widest_band(tracks)
    found = max(_energy_band(track, dynamics, theta) for track in tracks)
    if found < most:
        return Band(found, f"holds {100 * _ENERGY:.1f} % of the energy of the model's torque")
    return Band(most, f"{_FLAT} of the bandwidth of the positions")


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
    return rows


def _track_rows(track: Track, dynamics: Dynamics, gate: Array, band: float) -> Rows:
    used = moving(track, gate)
    joints, width = used.shape[1], len(dynamics.parameters) + 1
    grams = np.zeros((joints, width, width))
    equations = np.zeros(joints)
    parts: list[tuple[int, Array]] = []
    chunk = _Chunk(track, dynamics)
    for number, piece, basis in _active_stretches(track, used, band):
        system = np.where(used[piece][:, :, None], chunk.system(piece), 0.0)
        for j in range(joints):
            grams[j] += system[:, j].T @ system[:, j]
            equations[j] += float(used[piece][:, j] @ np.sum(basis**2, axis=1))
        parts.append((number, _project(basis, system)))
    degree, size = _stretch(track, band)
    frequency = np.arange(degree + 1) * track.rate / (2 * size)
    return _collect(parts, frequency, grams, used.sum(axis=0), equations, width)


def project_columns(track: Track, gate: Array, band: float, columns: Array) -> Array:
    """Further columns (N, J, K), known at the samples of a track, as rows (R, K) in the order of `measured_rows`."""
    used = moving(track, gate)
    parts = [
        _project(basis, np.where(used[piece][:, :, None], columns[piece], 0.0))
        for _, piece, basis in _active_stretches(track, used, band)
    ]
    return np.concatenate(parts, axis=1).reshape(-1, columns.shape[2])


def _project(basis: Array, system: Array) -> Array:
    """Coefficients (J, n + 1, K) of columns (N_s, J, K) on the polynomials of a stretch (N_s, n + 1)."""
    samples, joints, width = system.shape
    return (basis.T @ system.reshape(samples, -1)).reshape(-1, joints, width).transpose(1, 0, 2)


def _active_stretches(track: Track, used: Mask, band: float) -> Iterator[tuple[int, slice, Array]]:
    """Number, samples and polynomials of the stretches in which anything moves."""
    for number, (piece, basis) in enumerate(stretch_bases(track, band, len(used))):
        if used[piece].any():
            yield number, piece, basis


def stretch_bases(track: Track, band: float, count: int) -> Iterator[tuple[slice, Array]]:
    """Equal stretches of the first `count` samples, each with polynomials orthonormal on them (N_s, n + 1)."""
    degree, size = _stretch(track, band)
    edges = np.linspace(0, count, max(1, round(count / size)) + 1).astype(int)
    cache: dict[int, Array] = {}
    for start, stop in itertools.pairwise(edges):
        piece = slice(int(start), int(stop))
        yield piece, _basis(track, piece, min(degree, stop - start - 1), cache)


def _stretch(track: Track, band: float) -> tuple[int, int]:
    """Degree and number of samples of a stretch: n = 2 f T, as many equations as the band holds, n <= 2.5 sqrt(N)."""
    longest = min(_LONGEST / (2 * band), track.rate * (_SHARP / (2 * band)) ** 2)
    size = int(np.clip(longest * track.rate, 16, len(track.motion.t)))
    degree = int(np.clip(np.ceil(2 * band * size / track.rate), 3, min(size - 1, int(_SHARP * np.sqrt(size)))))
    return degree, size


def _basis(track: Track, piece: slice, degree: int, cache: dict[int, Array]) -> Array:
    """Orthonormal polynomials (N, n + 1) on the samples of a stretch."""
    t = track.motion.t[piece]
    if not track.projections[0].operator.uniform:
        return degree_modes(2 * (t - t[0]) / (t[-1] - t[0]) - 1, degree).samples
    if len(t) not in cache:
        cache[len(t)] = degree_modes(np.linspace(-1.0, 1.0, len(t)), degree).samples
    return cache[len(t)]


class _Chunk:
    """[W Y] at the samples (N, J, P + 1) of a track, made a chunk at a time and never whole.

    Chunks are long, because an effect with a memory (presliding) begins anew in each.
    """

    def __init__(self, track: Track, dynamics: Dynamics) -> None:
        self._track, self._dynamics = track, dynamics
        self._start, self._values = 0, np.zeros((0, 0, 0))

    def system(self, piece: slice) -> Array:
        """Rows of a stretch; stretches are asked for in order."""
        if piece.stop > self._start + len(self._values):
            self._start = piece.start
            ahead = slice(piece.start, max(piece.stop, piece.start + _CHUNK))
            regressor = self._dynamics.regressor(_cut(self._track.motion, ahead))
            self._values = np.concatenate([regressor, self._track.torque[ahead][:, :, None]], axis=2)
        return self._values[piece.start - self._start : piece.stop - self._start]


def _cut(motion: Motion, piece: slice) -> Motion:
    tau = None if motion.tau is None else motion.tau[piece]
    return Motion(motion.t[piece], motion.q[piece], motion.dq[piece], motion.ddq[piece], tau)


def _collect(
    parts: list[tuple[int, Array]], frequency: Array, grams: Array, samples: Array, equations: Array, width: int
) -> Rows:
    joints, degree = len(grams), len(frequency) - 1
    system = np.concatenate([part for _, part in parts], axis=1) if parts else np.zeros((joints, 0, width))
    blocks = np.repeat([number for number, _ in parts], degree + 1)
    return Rows(
        W=system[:, :, :-1].reshape(-1, width - 1),
        Y=system[:, :, -1].reshape(-1),
        joint=np.repeat(np.arange(joints), system.shape[1]),
        frequency=np.tile(frequency, joints * len(parts)),
        block=np.tile(blocks, joints).astype(int),
        noise=tuple(JointNoise(grams[j], int(samples[j]), float(equations[j])) for j in range(joints)),
    )
