"""Motions with their exact derivatives, and the encoder that measures them.

Every motion is a function t (N,) s -> (q, dq, ddq), (N,) each in rad, rad/s, rad/s^2. An encoder of b bits per turn
reports round((q + e) / c) c with c = 2 pi / 2^b and e Gaussian, white, of standard deviation `sigma` rad.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.signal import cont2discrete, lfilter, ss2tf

Array = np.ndarray
Motion = Callable[[Array], tuple[Array, Array, Array]]


@dataclass(frozen=True)
class Encoder:
    bits: int
    sigma: float  # rad

    @property
    def count(self) -> float:
        return 2 * np.pi / 2**self.bits

    @property
    def noise(self) -> float:
        """Standard deviation in rad of all it adds."""
        return float(np.hypot(self.count / np.sqrt(12), self.sigma))

    def measure(self, q: Array, seed: int) -> Array:
        noise = self.sigma * np.random.default_rng([seed, 1]).standard_normal(len(q))
        return np.round((q + noise) / self.count) * self.count


FINE = Encoder(16, 0.0)
COARSE = Encoder(13, 4e-4)


def multisine(seed: int, duration: float, highest: float = 3.0, sines: int = 10) -> Motion:
    """Ten sines of random phase at random frequencies below `highest` Hz, equal velocities, acceleration rms 16."""
    random = np.random.default_rng([seed, 2])
    omega = 2 * np.pi * random.uniform(0.05 * highest, highest, sines)
    phase = random.uniform(0, 2 * np.pi, sines)
    amplitude = 16 / np.sqrt(np.mean(omega**2) * sines / 2) / omega

    def motion(t: Array) -> tuple[Array, Array, Array]:
        angle = np.outer(t, omega) + phase
        return np.sin(angle) @ amplitude, np.cos(angle) @ (amplitude * omega), np.sin(angle) @ (-amplitude * omega**2)

    return motion


def quintic(seed: int, duration: float, move: float = 0.8, rest: float = 0.2) -> Motion:
    """Point-to-point moves of the fifth order (paper, eq. 23) to random places, a rest after each; jerk jumps."""
    random = np.random.default_rng([seed, 3])
    places = random.uniform(-1, 1, int(duration / (move + rest)) + 2)

    def motion(t: Array) -> tuple[Array, Array, Array]:
        index = np.minimum((t / (move + rest)).astype(int), len(places) - 2)
        u = np.clip((t - index * (move + rest)) / move, 0, 1)
        step = places[index + 1] - places[index]
        q = places[index] + step * u**3 * (10 - u * (15 - 6 * u))
        return q, step / move * 30 * (u * (1 - u)) ** 2, step / move**2 * 60 * u * (1 - u) * (1 - 2 * u)

    return motion


def chirp(seed: int, duration: float, low: float = 0.1, high: float = 5.0) -> Motion:
    """A sine whose frequency rises linearly, amplitude 0.3 rad."""
    phase = np.random.default_rng([seed, 4]).uniform(0, 2 * np.pi)
    slope = 2 * np.pi * (high - low) / duration

    def motion(t: Array) -> tuple[Array, Array, Array]:
        angle, omega = 2 * np.pi * low * t + slope * t**2 / 2 + phase, 2 * np.pi * low + slope * t
        s, c = np.sin(angle), np.cos(angle)
        return 0.3 * s, 0.3 * omega * c, 0.3 * (slope * c - omega**2 * s)

    return motion


def bang_bang(seed: int, duration: float, acceleration: float = 5.0) -> Motion:
    """Accelerations +a, -a by turns, switching every 0.3 to 0.8 s in symmetric pairs: the velocity returns to 0."""
    random = np.random.default_rng([seed, 5])
    lengths = random.uniform(0.3, 0.8, int(duration / 0.6) + 2)
    signs = random.choice([-1.0, 1.0], len(lengths))
    edges = np.concatenate([[0], np.cumsum(np.repeat(lengths, 2))])
    levels = acceleration * (signs[:, None] * [1.0, -1.0]).ravel()
    dq = np.concatenate([[0], np.cumsum(levels * np.diff(edges))])
    q = np.concatenate([[0], np.cumsum(dq[:-1] * np.diff(edges) + levels * np.diff(edges) ** 2 / 2)])

    def motion(t: Array) -> tuple[Array, Array, Array]:
        k = np.clip(np.searchsorted(edges, t, "right") - 1, 0, len(levels) - 1)
        u = t - edges[k]
        return q[k] + dq[k] * u + levels[k] * u**2 / 2, dq[k] + levels[k] * u, levels[k]

    return motion


def closed_loop(seed: int, duration: float, bandwidth: float = 6.0) -> Motion:
    """The moves of `quintic` as a servo loop of second order follows them, pushed back by Coulomb friction.

    Integrated exactly between steps of 0.1 ms with the input held; between steps linear (1e-8 rad).
    """
    step, omega, damping = 1e-4, 2 * np.pi * bandwidth, 0.7
    grid = np.arange(0, duration + 2 * step, step)
    reference, speed, _ = quintic(seed, duration)(grid)
    pushed = reference - 0.01 * np.tanh(speed / 0.02)
    dynamics = np.array([[0, 1], [-(omega**2), -2 * damping * omega]])
    system = (dynamics, np.array([[0], [omega**2]]), np.eye(2), np.zeros((2, 1)))
    numerators, denominator = ss2tf(*cont2discrete(system, step, "zoh")[:4])
    q, dq = (lfilter(numerator, denominator, pushed - pushed[0]) for numerator in numerators)
    ddq = omega**2 * (pushed - pushed[0] - q) - 2 * damping * omega * dq

    def motion(t: Array) -> tuple[Array, Array, Array]:
        return np.interp(t, grid, q + pushed[0]), np.interp(t, grid, dq), np.interp(t, grid, ddq)

    return motion


MOTIONS = {f.__name__: f for f in (multisine, quintic, chirp, bang_bang, closed_loop)}
