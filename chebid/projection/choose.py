"""Choosing the operator: from what the user set (degree, bandwidth, fit), or from the data when nothing is set.

What is not set is chosen by generalised cross-validation (Golub, Heath, Wahba, Technometrics 21, 1979),
    GCV = (RSS / N) / (1 - tr H / N)^2,
over window lengths that halve from the whole record on, a few degrees, and the penalty (or the degree, without one).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.errors import NoAnswerError, UsageError
from chebid.projection.modes import DegreeModes, PenaltyModes, degree_modes, penalty_modes
from chebid.projection.operator import Operator, Plan, is_uniform, limit

_DEGREES = (125, 88)  # of the windows tried; two, so that n / T comes in steps of sqrt(2)
_FEWEST = 24  # samples in the shortest window
_LONGEST = 16384  # samples in the longest window tried
_EXCERPT = 65536  # samples of a long record that are looked at
_CAUTION = 1.4  # on tr H in GCV, against undersmoothing by chance (Kim and Gu, J. R. Stat. Soc. B 66, 2004)
_MARGIN = 1.25  # windows are planned for 1.25 times the bandwidth asked for: gain 1 up to it at every place
_SHARP = 2.5  # n <= 2.5 sqrt(N) in a window of the unpenalised fits


@dataclass(frozen=True)
class Setting:
    """What the user set of a projection; None is automatic. `bandwidth` in Hz, `degree` of the whole record."""

    fit: str | None = None
    basis: str = "chebyshev"
    degree: int | None = None
    bandwidth: float | None = None


def plan(t: Array, x: Array, setting: Setting) -> Plan:
    """The plan for one signal x (N,) at t (N,) s.

    Raises UsageError when degree and bandwidth are both set or not positive, NoAnswerError when the record is too
    short.
    """
    if setting.degree is not None and setting.bandwidth is not None:
        raise UsageError(
            "both a degree and a bandwidth are set", hint="set one of them: degree = pi * bandwidth * duration"
        )
    if setting.degree is not None:
        return _from_degree(t, x, setting.degree, setting)
    if setting.bandwidth is not None:
        return from_bandwidth(t, setting.bandwidth, setting.fit or "lsq", setting.basis)
    return _from_data(t, x, setting)


def from_bandwidth(t: Array, bandwidth: float, fit: str = "lsq", basis: str = "chebyshev") -> Plan:
    """The plan that passes everything up to `bandwidth` Hz on a record at t (N,) s. Needs no data."""
    span, rate = float(t[-1] - t[0]), (len(t) - 1) / float(t[-1] - t[0])
    if not 0 < bandwidth < rate / 2:
        raise UsageError(
            f"bandwidth {bandwidth:g} Hz is not between 0 and half the rate, {rate / 2:g} Hz",
            hint="robot motion is usually below 20 Hz; leave it out and chebid chooses it",
        )
    if fit == "smooth":
        return _smooth_plan(span, rate, bandwidth, basis)
    degree = max(1, round(np.pi * bandwidth * span))
    if degree <= 3 * np.sqrt(len(t)):
        return Plan(fit, basis, degree, None, np.inf, degree / (np.pi * span), f"degree = pi {bandwidth:g} Hz T")
    window = (_SHARP / (_MARGIN * np.pi * bandwidth)) ** 2 * rate
    window = 2 * span / (max(1, round(2 * span / window - 1)) + 1)
    degree = int(min(_MARGIN * np.pi * bandwidth * window, limit(fit, int(window * rate))))
    reason = f"windows of {window:.3g} s, so that n <= {_SHARP} sqrt(N) at {bandwidth:g} Hz"
    return Plan(fit, basis, max(degree, 1), window, np.inf, bandwidth, reason)


def _smooth_plan(span: float, rate: float, bandwidth: float, basis: str) -> Plan:
    """Penalty with its -3 dB point at the bandwidth, on windows whose degree resolves 1.5 times the half-gain point."""
    half_gain = bandwidth / _THREE_DB
    window = min(span, _DEGREES[0] / (1.5 * np.pi * half_gain))
    window = 2 * span / (max(1, round(2 * span / window - 1)) + 1)
    degree = int(np.clip(1.5 * np.pi * half_gain * window, 12, limit("smooth", int(window * rate))))
    reason = f"penalty with -3 dB at {bandwidth:g} Hz"
    return Plan("smooth", basis, degree, window if window < span else None, half_gain, bandwidth, reason)


_THREE_DB = (np.sqrt(2) - 1) ** 0.125  # of 1 / (1 + (f / f0)^8)


def _from_degree(t: Array, x: Array, degree: int, setting: Setting) -> Plan:
    if degree < 1:
        raise UsageError(f"degree {degree} is below 1", hint="the paper uses 125; leave it out and chebid chooses it")
    span = float(t[-1] - t[0])
    fit, cut = setting.fit or "lsq", degree / (np.pi * span)
    given = Plan(fit, setting.basis, degree, None, np.inf, cut, "degree as set")
    if fit != "smooth":
        return given
    Operator(t, given)  # the guard on the degree
    found = _Tiling(t, x, 1, degree, is_uniform(t)).best_penalty()
    return Plan(fit, setting.basis, degree, None, found.penalty, found.bandwidth, "degree as set, penalty by GCV")


@dataclass(frozen=True)
class _Found:
    score: float
    tiles: int
    degree: int
    penalty: float
    bandwidth: float
    noise: float


@dataclass(frozen=True)
class _Tiling:
    """The samples looked at, cut in equal tiles side by side: every tiling is judged on the same samples."""

    t: Array  # (N,) s
    x: Array  # (N,)
    tiles: int
    degree: int
    uniform: bool

    @property
    def half(self) -> float:
        """Half-length of a tile in s."""
        return float(self.t[-1] - self.t[0]) / (2 * self.tiles)

    @property
    def rate(self) -> float:
        return (len(self.t) - 1) / float(self.t[-1] - self.t[0])

    @property
    def cut(self) -> float:
        """Frequency in Hz that the degree resolves in the middle of a tile."""
        return self.degree / (2 * np.pi * self.half)

    def pieces(self, kind: str) -> Iterator[tuple[PenaltyModes | DegreeModes, Array]]:
        """Modes of each tile and its samples (N_w, K): all tiles at once where they share a grid."""
        make = penalty_modes if kind == "smooth" else degree_modes
        size = len(self.t) // self.tiles
        if self.uniform:
            grid = np.linspace(-1.0, 1.0, size)
            yield make((grid - grid[::-1]) / 2, self.degree), self.x[: size * self.tiles].reshape(self.tiles, size).T
            return
        for k in range(self.tiles):
            t = self.t[k * size : (k + 1) * size]
            tau = 2 * (t - t[0]) / (t[-1] - t[0]) - 1
            yield make(tau, self.degree), self.x[k * size : (k + 1) * size, None]

    def gcv(self, kind: str, parameters: Array) -> tuple[Array, Array]:
        """GCV score and noise variance (P,) for every parameter: penalty weights in tau, or degrees."""
        rss, trace, total = np.zeros(len(parameters)), np.zeros(len(parameters)), 0
        for modes, x in self.pieces(kind):
            z = modes.samples.T @ x
            outside = np.sum((x - modes.samples @ z) ** 2)
            transfer = np.array([modes.transfer(parameter) for parameter in parameters])
            rss += outside + (1 - transfer) ** 2 @ np.sum(z**2, axis=1)
            trace += transfer.sum(axis=1) * x.shape[1]
            total += x.size
        return rss / total / np.maximum(1 - _CAUTION * trace / total, 1e-9) ** 2, rss / (total - trace)

    def best_penalty(self) -> _Found:
        penalties = np.geomspace(max(self.cut / 40, 1 / self.half), min(8 * self.cut, 0.45 * self.rate), 60)
        weights = np.array([Plan(penalty=p).weight(self.rate, self.half) for p in penalties])
        score, noise = self.gcv("smooth", weights)
        best = int(np.argmin(score))
        bandwidth = float(min(_THREE_DB * penalties[best], self.cut))
        return _Found(
            score[best], self.tiles, self.degree, float(penalties[best]), bandwidth, float(np.sqrt(noise[best]))
        )

    def best_degree(self) -> _Found:
        degrees = np.arange(2.0, self.degree + 1)
        score, noise = self.gcv("lsq", degrees)
        best = int(np.argmin(score))
        cut = float(degrees[best] / (2 * np.pi * self.half))
        return _Found(score[best], self.tiles, int(degrees[best]), np.inf, cut, float(np.sqrt(noise[best])))


def _tilings(t: Array, x: Array, fit: str, uniform: bool) -> Iterator[_Tiling]:
    """Tiles of T, T/2, T/4 ... with the degrees that fit them."""
    tiles = 1
    while tiles == 1 or len(t) // tiles >= _FEWEST:
        size = len(t) // tiles
        if size <= _LONGEST:
            most = limit("smooth", size) if fit == "smooth" else int(_SHARP * np.sqrt(size))
            wanted = _DEGREES if fit == "smooth" else (2 * _DEGREES[0],)
            for degree in sorted({min(n, most, size - 2) for n in wanted}):
                yield _Tiling(t, x, tiles, degree, uniform)
        tiles *= 2


def _excerpt(t: Array, x: Array, uniform: bool) -> tuple[Array, Array]:
    """The livelier part of a long record: the choice needs no more than this, whatever the length."""
    most = _EXCERPT if uniform else _EXCERPT // 4
    if len(t) <= most:
        return t, x
    starts = np.arange(0, len(t) - most + 1, most // 2)
    energy = [np.sum(np.diff(x[s : s + most : 16], n=2) ** 2) for s in starts]
    start = starts[int(np.argmax(energy))]
    return t[start : start + most], x[start : start + most]


def _from_data(t: Array, x: Array, setting: Setting) -> Plan:
    if len(t) < _FEWEST:
        raise NoAnswerError(f"a record of {len(t)} samples is too short to choose a filter", hint="record at least 1 s")
    fit = setting.fit or "smooth"
    uniform = is_uniform(t)
    part, signal = _excerpt(t, x, uniform)
    tried = [
        tiling.best_penalty() if fit == "smooth" else tiling.best_degree()
        for tiling in _tilings(part, signal, fit, uniform)
    ]
    found = min(tried, key=lambda f: f.score)
    window = None if found.tiles == 1 and len(part) == len(t) else float(part[-1] - part[0]) / found.tiles
    reason = f"generalised cross-validation over {len(tried)} window lengths and degrees"
    return Plan(fit, setting.basis, found.degree, window, found.penalty, found.bandwidth, reason)
