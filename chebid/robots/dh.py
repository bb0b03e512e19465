"""A serial arm from a table of Denavit and Hartenberg."""

import numpy as np

from chebid.model.schema import Link
from chebid.robots.chain import Tree, straightened
from chebid.robots.robot import Array


def dh_tree(table: tuple[Link, ...], convention: str, gravity: tuple[float, float, float]) -> Tree:
    """Rows (alpha, a, d, theta); the joint's position is added to theta, or to d where it slides.

    standard: Rz(theta) Tz(d) Tx(a) Rx(alpha), a row leads from joint to joint (Denavit and Hartenberg).
    modified: Rx(alpha) Tx(a) Rz(theta) Tz(d), alpha and a those of the body before (Craig; Khalil and Kleinfinger).
    In both the frame of a body, in which its parameters stand, has its z axis along its own joint: ZZ is the inertia
    that its motor feels.
    """
    across = [_screw(0, link.alpha, link.a) for link in table]
    if convention == "standard":
        across = [(np.eye(3), np.zeros(3)), *across[:-1]]
    poses = [_then(before, _screw(2, link.theta, link.d)) for before, link in zip(across, table, strict=True)]
    turns = [link.type == "revolute" for link in table]
    return Tree(
        parent=tuple(range(-1, len(table) - 1)),
        rotation=np.array([rotation for rotation, _ in poses]),
        origin=np.array([origin for _, origin in poses]),
        turn=np.array([(0.0, 0.0, float(turn)) for turn in turns]),
        slide=np.array([(0.0, 0.0, float(not turn)) for turn in turns]),
        gravity=np.array(gravity),
    )


def _screw(axis: int, angle: float, way: float) -> tuple[Array, Array]:
    """Rotation about a coordinate axis, and translation along it."""
    c, s = np.cos(angle), np.sin(angle)
    R = np.roll(np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]), axis, axis=(0, 1))
    return straightened(R), way * np.eye(3)[axis]


def _then(first: tuple[Array, Array], second: tuple[Array, Array]) -> tuple[Array, Array]:
    return first[0] @ second[0], first[1] + first[0] @ second[1]
