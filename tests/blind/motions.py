"""Motions within limits: point to point, multisine, Fourier series, slow-fast sweeps, repeated periods."""

from dataclasses import dataclass, replace

import numpy as np
from blind.world import Array

KINDS = ("dwell", "moves", "multisine", "fourier", "sweep", "periodic")
# never drawn for the study proper: accelerations that jump, and content beyond what a projection keeps
HARSH = ("trapezoid", "wideband")


@dataclass(frozen=True)
class Limits:
    """Largest position, velocity and acceleration of each joint (J,)."""

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True)
class Moves:
    """Quintics from point to point: times (M+1,) at which each move begins, lengths (M,), points (M+1, J)."""

    begin: Array
    length: Array
    points: Array
    blend: float = 0.0  # share of a move over which the velocity ramps; 0 is the quintic

    def __call__(self, t: Array) -> tuple[Array, Array]:
        at = np.clip(np.searchsorted(self.begin, t, side="right") - 1, 0, len(self.length) - 1)
        s = np.clip((t - self.begin[at]) / self.length[at], 0.0, 1.0)[:, None]
        step = self.points[at + 1] - self.points[at]
        if self.blend:
            return self._trapezoid(s, step, at)
        q = self.points[at] + step * s**3 * (10 - 15 * s + 6 * s**2)
        return q, step * 30 * s**2 * (1 - s) ** 2 / self.length[at, None]

    def _trapezoid(self, s: Array, step: Array, at: Array) -> tuple[Array, Array]:
        b = self.blend
        top = 1 / (1 - b)
        speed = top * np.clip(np.minimum(s, 1 - s) / b, 0, 1)
        ramp = np.where(s < b, top * s**2 / (2 * b), top * (s - b / 2))
        way = np.where(s > 1 - b, 1 - top * (1 - s) ** 2 / (2 * b), ramp)
        return self.points[at] + step * way, step * speed / self.length[at, None]


@dataclass(frozen=True)
class Sines:
    """Sums of sines about a centre: frequencies (Hz), amplitudes and phases (J, M), faded in before the log."""

    centre: Array
    frequency: Array
    amplitude: Array
    phase: Array

    def __call__(self, t: Array) -> tuple[Array, Array]:
        w = 2 * np.pi * self.frequency
        angle = t[:, None, None] * w + self.phase
        q = self.centre + (self.amplitude * np.sin(angle)).sum(axis=2)
        return q, (self.amplitude * w * np.cos(angle)).sum(axis=2)


@dataclass(frozen=True)
class Sweep:
    """One sine per joint whose frequency goes slow - fast - slow while its peak velocity stays within limits."""

    centre: Array
    amplitude: Array
    slow: Array
    fast: Array
    period: float
    phase: Array

    def __call__(self, t: Array) -> tuple[Array, Array]:
        w = 2 * np.pi / self.period
        middle, swing = (self.slow + self.fast) / 2, (self.fast - self.slow) / 2
        f = middle - swing * np.cos(w * t)[:, None]
        turns = middle * t[:, None] - swing / w * np.sin(w * t)[:, None]
        angle = 2 * np.pi * turns + self.phase
        # the amplitude falls as the frequency rises, smoothly
        size = self.amplitude / (1 + (f / middle) ** 2)
        fall = -2 * size / (1 + (f / middle) ** 2) * f / middle**2 * swing * w * np.sin(w * t)[:, None]
        return self.centre + size * np.sin(angle), fall * np.sin(angle) + size * 2 * np.pi * f * np.cos(angle)


def draw(kind: str, limits: Limits, duration: float, rng: np.random.Generator) -> "Moves | Sines | Sweep":
    """A random motion of a kind that uses 60 to 100 % of its limits."""
    share = Limits(*(rng.uniform(0.6, 1.0) * x for x in (limits.position, limits.velocity, limits.acceleration)))
    if kind == "trapezoid":
        return replace(_moves(share, duration, rng, dwell=False), blend=rng.uniform(0.25, 0.4))
    if kind == "wideband":
        return _fit(np.sort(rng.uniform(0.2, 7.0, 9)), share, duration, rng)
    make = {"dwell": _moves, "moves": _moves, "multisine": _multisine, "fourier": _fourier, "periodic": _periodic}
    if kind == "sweep":
        return _sweep(share, duration, rng)
    return make[kind](share, duration, rng, **({"dwell": kind == "dwell"} if kind in ("dwell", "moves") else {}))


def _moves(limits: Limits, duration: float, rng: np.random.Generator, dwell: bool) -> Moves:
    points = [rng.uniform(-1, 1, len(limits.position)) * limits.position]
    begin, length = [-0.2], []
    while begin[-1] < duration + 1:
        goal = rng.uniform(-1, 1, len(limits.position)) * limits.position
        far = np.abs(goal - points[-1])
        # peaks of a quintic: 15/8 of the mean velocity, 10/sqrt(3) d/T² of acceleration
        least = max((15 / 8 * far / limits.velocity).max(), np.sqrt(10 / np.sqrt(3) * far / limits.acceleration).max())
        length.append(max(0.4, least * rng.uniform(1.0, 1.6)))
        points.append(goal)
        begin.append(begin[-1] + length[-1] + (rng.uniform(0.1, 0.6) if dwell else 0.0))
    return Moves(np.array(begin[:-1]), np.array(length), np.array(points))


def _fit(frequency: Array, limits: Limits, duration: float, rng: np.random.Generator) -> Sines:
    """Amplitudes that fall with the frequency, all scaled to touch the nearest limit."""
    joints = len(limits.position)
    w = 2 * np.pi * frequency
    amplitude = rng.uniform(0.3, 1.0, (joints, len(frequency))) / (1 + (frequency / frequency.mean()) ** 2)
    phase = rng.uniform(0, 2 * np.pi, amplitude.shape)
    t = np.arange(0, duration, 0.01)[:, None, None]
    angle = t * w + phase
    peaks = [np.abs((amplitude * wave).sum(axis=2)).max(axis=0)
             for wave in (np.sin(angle), w * np.cos(angle), w**2 * np.sin(angle))]  # fmt: skip
    bounds = (limits.position, limits.velocity, limits.acceleration)
    scale = np.min([limit / peak for limit, peak in zip(bounds, peaks, strict=True)], axis=0)
    return Sines(np.zeros(joints), frequency, amplitude * scale[:, None], phase)


def _multisine(limits: Limits, duration: float, rng: np.random.Generator) -> Sines:
    top = rng.uniform(0.8, 2.0)
    return _fit(np.sort(rng.uniform(0.08, top, rng.integers(3, 8))), limits, duration, rng)


def _fourier(limits: Limits, duration: float, rng: np.random.Generator) -> Sines:
    base = 1 / max(duration * rng.uniform(0.9, 1.2), 8.0)
    return _fit(base * np.arange(1, 1 + int(rng.integers(5, 13))), limits, duration, rng)


def _periodic(limits: Limits, duration: float, rng: np.random.Generator) -> Sines:
    base = rng.integers(3, 8) / duration
    base = min(max(base, 0.12), 0.5)
    return _fit(base * np.arange(1, 1 + int(rng.integers(2, 6))), limits, duration, rng)


def _sweep(limits: Limits, duration: float, rng: np.random.Generator) -> Sweep:
    joints = len(limits.position)
    slow, fast = rng.uniform(0.05, 0.15, joints), rng.uniform(0.7, 1.6, joints)
    period, phase = duration / rng.integers(1, 4), rng.uniform(0, 2 * np.pi, joints)
    unit = Sweep(np.zeros(joints), np.ones(joints), slow, fast, period, phase)
    t = np.arange(0, duration, 0.005)
    q, dq = unit(t)
    peaks = [np.abs(x).max(axis=0) for x in (q, dq, np.gradient(dq, 0.005, axis=0))]
    bounds = (limits.position, limits.velocity, limits.acceleration)
    scale = np.min([limit / peak for limit, peak in zip(bounds, peaks, strict=True)], axis=0)
    return Sweep(np.zeros(joints), scale, slow, fast, period, phase)
