"""Point-to-point motions: fifth-order polynomials with rest at each point, all joints starting and stopping together.

A move over a distance D in d seconds is q = p + D s(x), x = (t - start)/d, s = 10 x^3 - 15 x^4 + 6 x^5; its largest
velocity is 15/8 D/d and its largest acceleration 10/sqrt(3) D/d^2, so that the limits are those of the distances.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.excite.descent import Objective, descend
from chebid.excite.limits import Limits, full_size
from chebid.robots import Array

FASTEST, STRONGEST = 15 / 8, 10 / np.sqrt(3)
_LEAST = 0.05  # of the mean duration of a move, that each one has at least
_NEAR_FULL = 3.0  # amplitude to start with: 95 % of what the limits allow


@dataclass(frozen=True)
class Points:
    """M moves between M + 1 points (M + 1, J), of durations (M,) s; as a vector, points first.

    `uneven`: random motions have moves of very different durations, and so pass slowly and fast.
    """

    limits: Limits
    duration: float
    moves: int
    uneven: bool = False

    @property
    def joints(self) -> int:
        return len(self.limits.position)

    def split(self, x: Array) -> tuple[Array, Array]:
        """Points and durations of a vector."""
        count = (self.moves + 1) * self.joints
        return x[:count].reshape(-1, self.joints), x[count:]

    def random(self, random: np.random.Generator) -> Array:
        """A motion within the limits: each move as far as it may go, or less, one way or the other."""
        durations = self._durations(random)
        points = [random.uniform(-1, 1, self.joints) * self.limits.position]
        for reach in self._reach(durations):
            low = np.maximum(points[-1] - reach, -self.limits.position)
            high = np.minimum(points[-1] + reach, self.limits.position)
            points.append(low + (high - low) * random.beta(0.5, 0.5, self.joints))
        return np.concatenate([np.ravel(points), durations])

    def _durations(self, random: np.random.Generator) -> Array:
        if not self.uneven:
            return random.dirichlet(np.full(self.moves, 5.0)) * self.duration
        return self.duration * (_LEAST / self.moves + (1 - _LEAST) * random.dirichlet(np.ones(self.moves)))

    def _reach(self, durations: Array) -> Array:
        """Largest distance (M, J) in the given times."""
        d = durations[:, None]
        return np.minimum(self.limits.velocity * d / FASTEST, self.limits.acceleration * d**2 / STRONGEST)

    def motion(self, x: Array, t: Array) -> Array:
        """(3, N, J): q, dq, ddq at t (N,) s."""
        return self._curves(x, t)[0]

    def _curves(self, x: Array, t: Array) -> tuple[Array, Array, NDArray[np.int64], Array, Array]:
        """The motion, its rates by x = (t - start)/d (3, N, J), the moves (N,), their s, s', s'' (3, N), and x."""
        points, durations = self.split(x)
        starts = np.concatenate([[0.0], np.cumsum(durations)])
        move = np.clip(np.searchsorted(starts, t, side="right") - 1, 0, self.moves - 1)
        d = durations[move]
        at = np.clip((t - starts[move]) / d, 0.0, 1.0)
        shape = np.stack(_quintic(at))
        distance = (points[1:] - points[:-1])[move]
        per = np.stack([np.ones_like(d), 1 / d, 1 / d**2])
        motion = distance * (shape[:3] * per)[:, :, None]
        rates = distance * (shape[1:] * per)[:, :, None]
        motion[0] += points[move]
        return motion, rates, move, shape[:3] * per, at

    def gradient(self, x: Array, t: Array, by_motion: Array) -> Array:
        """Of a function of the motion whose gradient by the motion is known (3, N, J)."""
        _, durations = self.split(x)
        motion, rates, move, shape, at = self._curves(x, t)
        pulls = np.einsum("onj,on->nj", by_motion, shape)
        by_points = np.zeros((self.moves + 1, self.joints))
        np.add.at(by_points, move + 1, pulls)
        np.add.at(by_points, move, by_motion[0] - pulls)
        by_x = np.einsum("onj,onj->n", by_motion, rates) / durations[move]
        stretch = np.einsum("nj,nj->n", by_motion[1], motion[1]) + 2 * np.einsum("nj,nj->n", by_motion[2], motion[2])
        own = np.bincount(move, -(by_x * at + stretch / durations[move]), self.moves)
        later = np.bincount(move, by_x, self.moves)
        return np.concatenate([by_points.ravel(), own - (later.sum() - np.cumsum(later))])

    def improve(self, criterion: Objective, x: Array, iterations: int) -> Array:
        """The nearest best motion within the limits (SLSQP on free points and durations, sized to the limits)."""
        shape, durations = self.split(x)
        free = np.concatenate([shape.ravel(), np.log(durations), np.full(self.joints, _NEAR_FULL)])

        def target(free: Array) -> tuple[float, Array]:
            vector, pull = self._sized(free)
            value, by_motion = criterion.objective(self.motion(vector, criterion.t))
            return value, pull(self.gradient(vector, criterion.t, by_motion))

        return self._sized(descend(target, free, iterations, criterion.pointwise))[0]

    def _sized(self, free: Array) -> tuple[Array, Callable[[Array], Array]]:
        """The motion that free numbers stand for: points of any size, logarithms of durations, amplitudes.

        Returns its vector, and the function that turns a gradient by that into one by the free numbers.
        """
        count = (self.moves + 1) * self.joints
        shape, logarithms, amplitude = free[:count].reshape(-1, self.joints), *np.split(free[count:], [self.moves])
        weights = np.exp(logarithms - logarithms.max())
        weights /= weights.sum()
        durations = self.duration * (_LEAST / self.moves + (1 - _LEAST) * weights)
        d, distance = durations[:, None], np.diff(shape, axis=0)
        per = FASTEST / self.limits.velocity / d, STRONGEST / self.limits.acceleration / d**2
        parts = np.concatenate([shape / self.limits.position, distance * per[0], distance * per[1]])
        size, by_size = full_size(np.abs(parts), amplitude)

        def pull(by_vector: Array) -> Array:
            by_points, by_durations = by_vector[:count].reshape(shape.shape), by_vector[count:].copy()
            by_parts, by_amplitude = by_size((by_points * shape).sum(axis=0))
            by_place, by_fast, by_strong = np.split(by_parts * np.sign(parts), [len(shape), len(shape) + self.moves])
            fast, strong = by_fast * per[0], by_strong * per[1]
            by_durations -= ((fast + 2 * strong) * distance / d).sum(axis=1)
            by_shape = by_points * size + by_place / self.limits.position
            by_shape[1:] += fast + strong
            by_shape[:-1] -= fast + strong
            scaled = self.duration * (1 - _LEAST) * weights
            by_logarithms = scaled * (by_durations - weights @ by_durations)
            return np.concatenate([by_shape.ravel(), by_logarithms, by_amplitude])

        return np.concatenate([(shape * size).ravel(), durations]), pull


def _quintic(x: Array) -> tuple[Array, Array, Array, Array]:
    """s of x in [0, 1] and its three derivatives."""
    return (
        x**3 * (10 - 15 * x + 6 * x**2),
        30 * x**2 * (1 - x) ** 2,
        60 * x * (1 - x) * (1 - 2 * x),
        60 * (1 - 6 * x + 6 * x**2),
    )
