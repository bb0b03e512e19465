"""The planar two-axis SCARA of the paper: eq. 18 and 19 without the friction terms, which are effects."""

from dataclasses import dataclass

import numpy as np

from chebid.robots.robot import Array, Parameter


@dataclass(frozen=True)
class Scara:
    """Two revolute joints in a horizontal plane.

    ZZR1 = ZZ1 + M2 L^2; LMX2, LMY2: FIRST moments of body 2 times the length L of body 1 (the paper calls them
    principal moments of inertia); ZZ2: moment of inertia of body 2 about its joint. All in kg.m^2.
    """

    joints: tuple[str, ...]
    rotary = (True, True)
    positive = ("ZZR1", "ZZ2")

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        first, second = self.joints
        named = (("ZZR1", first), ("ZZ2", second), ("LMX2", second), ("LMY2", second))
        return tuple(Parameter(name, joint, "kg.m^2") for name, joint in named)

    def regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        """Eq. 18 with its three misprints corrected: q, dq, ddq (N, 2) in rad and s -> (N, 2, 4)."""
        cosine, sine = np.cos(q[:, 1]), np.sin(q[:, 1])
        both, coriolis = 2 * ddq[:, 0] + ddq[:, 1], dq[:, 1] * (2 * dq[:, 0] + dq[:, 1])
        out = np.zeros((len(q), 2, 4))
        out[:, 0, 0] = ddq[:, 0]
        out[:, :, 1] = (ddq[:, 0] + ddq[:, 1])[:, None]
        out[:, 0, 2] = both * cosine - coriolis * sine
        out[:, 1, 2] = ddq[:, 0] * cosine + dq[:, 0] ** 2 * sine
        out[:, 0, 3] = -both * sine - coriolis * cosine
        out[:, 1, 3] = dq[:, 0] ** 2 * cosine - ddq[:, 0] * sine
        return out
