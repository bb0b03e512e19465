"""Random arms, stages and sensors."""

import numpy as np
from blind.motions import Limits
from blind.world import Arm, Link

NOISE = 0.015  # nominal torque noise over rms torque


def scara(rng: np.random.Generator) -> tuple[Arm, Limits]:
    """A planar arm of a size between a desk toy and a pick-and-place robot; friction is set later, from the torques."""
    size = rng.uniform(0.6, 1.5)
    first = _link(rng, size * rng.uniform(0.25, 0.45), rng.uniform(4, 14) * size)
    second = _link(rng, size * rng.uniform(0.15, 0.35), rng.uniform(0.8, 4) * size)
    # the rotor of the first motor is indistinguishable from its link; one on the second would be a hidden effect
    first = Link(first.mass, first.inertia, first.com, first.length, armature=rng.uniform(0, 1.5) * first.inertia)
    limits = Limits(
        np.array([rng.uniform(1.0, 1.5), rng.uniform(1.4, 2.2)]),
        np.array([4.0, 8.0]) * rng.uniform(0.5, 1.0, 2),
        np.array([12.0, 40.0]) * rng.uniform(0.5, 1.0, 2),
    )
    elbow = second.inertia + second.mass * np.hypot(*second.com) ** 2
    reach = first.length + np.hypot(*second.com)
    shoulder = first.inertia + first.mass * np.hypot(*first.com) ** 2 + first.armature
    inertia = np.array([shoulder + second.inertia + second.mass * reach**2, elbow])
    return _controlled("scara", (first, second), inertia, (False, False), rng), limits


def axes(rng: np.random.Generator) -> tuple[Arm, Limits]:
    """One or two independent axes, each a positioning stage or a bench with a flywheel."""
    joints = int(rng.integers(1, 3))
    slides = tuple(bool(x) for x in rng.random(joints) < 0.6)
    links, limit = [], []
    for slide in slides:
        mass = rng.uniform(3, 60) if slide else rng.uniform(0.5, 4)
        links.append(Link(mass, 0.01 if slide else rng.uniform(0.01, 0.3)))
        bound = (rng.uniform(0.1, 0.4), rng.uniform(0.4, 1.2), rng.uniform(2, 8)) if slide else (
            rng.uniform(1, 3), rng.uniform(4, 10), rng.uniform(15, 50))  # fmt: skip
        limit.append(bound)
    inertia = np.array([link.mass if slide else link.inertia for link, slide in zip(links, slides, strict=True)])
    return _controlled("axes", tuple(links), inertia, slides, rng), Limits(*np.array(limit).T)


def _link(rng: np.random.Generator, length: float, mass: float) -> Link:
    com = (length * rng.uniform(0.3, 0.65), length * rng.uniform(-0.08, 0.08))
    return Link(mass, mass * length**2 * rng.uniform(0.06, 0.14), com, length)


def _controlled(
    kind: str, links: tuple[Link, ...], inertia: np.ndarray, slides: tuple[bool, ...], rng: np.random.Generator
) -> Arm:
    """PD gains for a stiff, well damped loop: 6 to 12 Hz."""
    w, zeta = 2 * np.pi * rng.uniform(6, 12, len(links)), rng.uniform(0.7, 1.0, len(links))
    kp, kd = inertia * w**2, 2 * zeta * w * inertia
    period = float(rng.choice([1e-3, 2e-3]))
    return Arm(kind, links, tuple(kp.tolist()), tuple(kd.tolist()), slides, period)


def with_friction(arm: Arm, torque: np.ndarray, speed: np.ndarray, rng: np.random.Generator) -> Arm:
    """Dry friction of 4 to 15 % of the rms torque of each joint, viscous of 3 to 12 % at the rms speed."""
    for j in range(arm.joints):
        dry, wet = rng.uniform(0.04, 0.15) * torque[j], rng.uniform(0.03, 0.12) * torque[j] / speed[j]
        arm = arm.with_link(j, friction=float(dry), damping=float(wet))
    return arm


def counts(arm: Arm, limits: Limits, rng: np.random.Generator) -> tuple[float, ...]:
    """Encoders of 15 to 18 bits over a turn, or of the same fineness over the travel of a stage."""
    out = []
    for j in range(arm.joints):
        span = 10 * limits.position[j] if arm.prismatic[j] else 2 * np.pi
        out.append(float(span / 2 ** int(rng.integers(15, 19))))
    return tuple(out)
