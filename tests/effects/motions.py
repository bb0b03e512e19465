"""Motions and effects for the tests of the library."""

import numpy as np

from chebid.dynamics import Dynamics
from chebid.effects import LIBRARY, Effect, Motion
from chebid.robots import Axes, Robot, Scara

SCARA = Scara(("q1", "q2"))
STAGE = Axes(("x", "a"), ("prismatic", "revolute"))
RIGID = np.array([3.45, 0.061, 0.124, 0.008])


def smooth(seed: int = 0, count: int = 2000, duration: float = 20.0, joints: int = 2, size: float = 0.6) -> Motion:
    """Sums of sines with exact derivatives, 0 to `duration` s."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, duration, count)
    w = 2 * np.pi * rng.uniform(0.1, 0.8, (5, joints))
    a = size * rng.uniform(0.3, 1.0, (5, joints))
    angle = t[:, None, None] * w + rng.uniform(0, 2 * np.pi, (5, joints))
    q, dq, ddq = (np.sum(x, axis=1) for x in (a * np.sin(angle), a * w * np.cos(angle), -a * w**2 * np.sin(angle)))
    return Motion(t, q, dq, ddq)


def known(motion: Motion, robot: Robot = SCARA, seed: int = 1) -> Motion:
    """The motion with a model's own torque: that of the rigid robot with viscous friction."""
    base = Dynamics(robot, tuple(LIBRARY["viscous"](j) for j in range(len(robot.joints))))
    theta = np.random.default_rng(seed).uniform(0.5, 1.5, len(base.parameters))
    return base.prepare(motion, theta)


def all_of(motion: Motion, robot: Robot = SCARA) -> list[Effect]:
    """Every effect of the library on every joint, with the first, middle and last settings of its grid."""
    out = []
    for kind in LIBRARY.values():
        for joint in [None] if kind.whole_arm else range(len(robot.joints)):
            found = kind.candidates(motion, joint)
            out += [found[i].bind(robot) for i in sorted({0, len(found) // 2, len(found) - 1}) if found]
    return out


def label(effect: Effect) -> str:
    values = ",".join(f"{v:.3g}" if isinstance(v, float) else str(v) for v in effect.hyper.values())
    return f"{effect.name}-{effect.joint}({values})"
