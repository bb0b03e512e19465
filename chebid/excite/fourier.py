"""Periodic motions: Fourier series of the basic frequency 1/duration (Swevers et al., IEEE T-RA 13, 1997), each joint
its own amplitudes, starting and ending at rest with no acceleration.

The coefficients only give the shape of a joint's motion. Its size is as large as the limits allow: during the search
by a smooth bound (a p-norm, at least the maximum), at the end exactly.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import null_space

from chebid.excite.descent import Objective, descend
from chebid.excite.limits import Limits, full_size
from chebid.robots import Array

_POWER = 40  # of the norm: within 15 % of the maximum
_MARGIN = 1 - 1e-7
_FINE = 40  # instants per period of the highest harmonic, at which the limits are kept: peaks are right to 3e-3


@dataclass(frozen=True)
class Fourier:
    """A constant and H harmonics per joint, at rest at both ends; as a vector: shapes (J, 2 H - 1)."""

    limits: Limits
    duration: float
    harmonics: int

    @property
    def joints(self) -> int:
        return len(self.limits.position)

    def _basis(self, t: Array) -> Array:
        """(3, N, C): the free shapes that start at rest, and their derivatives."""
        w = 2 * np.pi / self.duration * np.arange(1, self.harmonics + 1)
        angle = np.outer(t, w)
        sine, cosine = np.sin(angle), np.cos(angle)
        value = np.hstack([np.ones((len(t), 1)), sine / w, cosine / w])
        slope = np.hstack([np.zeros((len(t), 1)), cosine, -sine])
        curve = np.hstack([np.zeros((len(t), 1)), -w * sine, -w * cosine])
        still = np.zeros((2, 2 * self.harmonics + 1))
        still[0, 1 : self.harmonics + 1] = 1.0  # velocity at the start
        still[1, self.harmonics + 1 :] = w  # acceleration there
        return np.stack([value, slope, curve]) @ null_space(still)

    def random(self, random: np.random.Generator) -> Array:
        """Any shapes, as large as the limits allow."""
        shapes = random.standard_normal((2 * self.harmonics - 1, self.joints))
        shares, _ = self._fine(shapes)
        return (shapes / shares.max(axis=0) * (1 - 4 / _FINE**2)).ravel()

    def motion(self, x: Array, t: Array) -> Array:
        """(3, N, J): q, dq, ddq at t (N,) s."""
        return self._basis(t) @ x.reshape(-1, self.joints)

    def _fine(self, shapes: Array) -> tuple[Array, Array]:
        """Shares of the limits (K, J) all along, and the basis there over the limits (K, C, J)."""
        t = np.linspace(0, self.duration, _FINE * self.harmonics + 1)
        basis = self._basis(t)
        per = np.einsum("onc,oj->oncj", basis, 1 / self.limits.stacked()).reshape(-1, basis.shape[2], self.joints)
        return np.abs(np.einsum("kcj,cj->kj", per, shapes)), per

    def improve(self, criterion: Objective, x: Array, iterations: int) -> Array:
        """The nearest best shapes (SLSQP on shapes of any size, sized to the limits)."""
        shapes = x.reshape(-1, self.joints)
        _, per = self._fine(shapes)
        basis = self._basis(criterion.t)

        def sized(free: Array) -> tuple[Array, Array, Any]:
            shapes, amplitude = free[: x.size].reshape(-1, self.joints), free[x.size :]
            raw = np.einsum("kcj,cj->kj", per, shapes)
            size, by_size = full_size(np.abs(raw) * (1 + 4 / _FINE**2), amplitude)

            def pull(by_sized: Array) -> Array:
                by_raw, by_amplitude = by_size((by_sized * shapes).sum(axis=0))
                by_raw = by_raw * np.sign(raw) * (1 + 4 / _FINE**2)
                by_shapes = by_sized * size + np.einsum("kcj,kj->cj", per, by_raw)
                return np.concatenate([by_shapes.ravel(), by_amplitude])

            return shapes * size, size, pull

        def target(free: Array) -> tuple[float, Array]:
            shapes, _, pull = sized(free)
            value, by_motion = criterion.objective(basis @ shapes)
            return value, pull(np.einsum("onc,onj->cj", basis, by_motion))

        free = np.concatenate([(shapes / np.linalg.norm(shapes, axis=0)).ravel(), np.full(self.joints, 3.0)])
        return sized(descend(target, free, iterations, criterion.pointwise))[0].ravel()
