"""Any tree of rigid bodies on joints of one freedom: the regressor of the Newton-Euler equations, and its base.

The recursion is that of Featherstone (Rigid Body Dynamics Algorithms, 2008, chapter 5) with the wrench of each body
kept linear in its ten parameters (Atkeson, An and Hollerbach, Int. J. Robotics Research 5, 1986). Not all of these
show in the torques. Those that do are found as Gautier does (J. Robotic Systems 8, 1991): columns of the regressor at
random states that depend on the columns before them are left out, and what they say is in the others.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from chebid.robots.robot import Array, Parameter

# Parameters of a body in the frame of its joint: inertia about the origin, first moment, mass (Khalil and Dombre).
_NAMES = ("XX", "XY", "XZ", "YY", "YZ", "ZZ", "MX", "MY", "MZ", "M")
_UNITS = dict.fromkeys(_NAMES[:6], "kg.m^2") | dict.fromkeys(_NAMES[6:9], "kg.m") | {"M": "kg"}
_KEEP_FIRST = ("XX", "XY", "XZ", "YZ", "ZZ", "YY", "MX", "MY", "MZ", "M")  # the usual choice of a base
_POSITIVE = frozenset({"XX", "YY", "ZZ", "M"})
_DEPENDS = 1e-9  # of the length of a column: what is left of it beside others that it depends on
_COUNTS = 1e-6  # of a unit: a share of another parameter that is more than rounding
_STATES = 40  # random ones; each gives as many equations as there are joints
_NEARLY = 1e-4  # rad: 1.5708 is meant to be a right angle
_PIECE = 1024  # samples at a time, so that their matrices stay in the cache


@dataclass(frozen=True, eq=False)
class Tree:
    """Kinematics: body i hangs on `parent[i]` (-1: the base), which comes before it.

    `rotation` (J, 3, 3) and `origin` (J, 3): pose of body i in its parent's frame at q = 0. `turn` and `slide` (J, 3):
    unit screw of its joint in the frame of body i; where it only slides, turn = 0. `gravity` (3,) in the base, m/s^2.
    """

    parent: tuple[int, ...]
    rotation: Array
    origin: Array
    turn: Array
    slide: Array
    gravity: Array

    def __len__(self) -> int:
        return len(self.parent)

    def poses(self, q: Array) -> Iterator[tuple[Array, Array]]:
        """Of every body in its parent's frame at q (N, J): rotations (N, 3, 3), origins (N, 3)."""
        for i, w in enumerate(self.turn):
            angle = q[:, i, None, None]
            W = cross(w)
            turned = np.eye(3) + np.sin(angle) * W + (1 - np.cos(angle)) * (W @ W)
            arm = np.cross(w, self.slide[i])  # from the origin to the axis
            way = (np.eye(3) - turned) @ arm if w.any() else q[:, i, None] * self.slide[i]
            yield self.rotation[i] @ turned, self.origin[i] + way @ self.rotation[i].T

    def regressor(self, q: Array, dq: Array, ddq: Array, gravity: Array | None = None) -> Array:
        """(N, J, 10 J) at states (N, J): torques per unit of every parameter of every body."""
        out = np.zeros((len(q), len(self), 10 * len(self)))
        for start in range(0, len(q), _PIECE):
            at = slice(start, start + _PIECE)
            self._fill(q[at], dq[at], ddq[at], self.gravity if gravity is None else gravity, out[at])
        return out

    def _fill(self, q: Array, dq: Array, ddq: Array, gravity: Array, out: Array) -> None:
        poses = list(self.poses(q))
        still, falling = np.zeros((len(q), 3)), np.broadcast_to(-gravity, (len(q), 3))
        states: list[tuple[Array, Array, Array, Array]] = []  # of each body: w, v, and their rates
        for i, ((R, p), up) in enumerate(zip(poses, self.parent, strict=True)):
            w, v, dw, dv = states[up] if up >= 0 else (still, still, still, falling)
            v, dv = v + np.cross(w, p), dv + np.cross(dw, p)
            w, v, dw, dv = ((x[:, None] @ R)[:, 0] for x in (w, v, dw, dv))
            turn, slide = self.turn[i] * dq[:, i, None], self.slide[i] * dq[:, i, None]
            w, v = w + turn, v + slide
            dw = dw + self.turn[i] * ddq[:, i, None] + np.cross(w, turn)
            dv = dv + self.slide[i] * ddq[:, i, None] + np.cross(w, slide) + np.cross(v, turn)
            states.append((w, v, dw, dv))
        for i, (w, v, dw, dv) in enumerate(states):
            columns = slice(10 * i, 10 * i + 10)
            force, moment = _wrench(w, dw, dv + np.cross(w, v))
            at = i
            while True:
                out[:, at, columns] = self.slide[at] @ force + self.turn[at] @ moment
                if self.parent[at] < 0:
                    break
                R, p = poses[at]
                force, moment = R @ force, R @ moment
                moment += cross(p) @ force
                at = self.parent[at]


def straightened(rotation: Array) -> Array:
    """The rotation (3, 3) with axes that are nearly at right angles made so.

    Angles are written with few digits, and what differs by a hundred-thousandth of itself cannot be told apart.
    """
    u, _, v = np.linalg.svd(np.where(np.abs(rotation) < _NEARLY, 0.0, rotation))
    return np.asarray(u @ v, dtype=np.float64)


def cross(x: Array) -> Array:
    """(..., 3, 3) with cross(x) @ y = x times y."""
    x, y, z = np.moveaxis(np.asarray(x, dtype=float), -1, 0)
    o = np.zeros_like(x)
    return np.stack([np.stack(row, -1) for row in ((o, -z, y), (z, o, -x), (-y, x, o))], -2)


def _wrench(w: Array, dw: Array, a: Array) -> tuple[Array, Array]:
    """Force and moment (N, 3, 10) at the origin of a body per unit of its parameters; a (N, 3): of its origin."""
    force, moment = np.zeros((2, len(w), 3, 10))
    W = cross(w)
    force[:, :, 6:9] = cross(dw) + W @ W
    force[:, :, 9] = a
    moment[:, :, :6] = _inertial(dw) + W @ _inertial(w)
    moment[:, :, 6:9] = -cross(a)
    return force, moment


def _inertial(w: Array) -> Array:
    """(N, 3, 6): the inertia tensor times w, per XX, XY, XZ, YY, YZ, ZZ."""
    x, y, z = w.T
    o = np.zeros_like(x)
    return np.moveaxis(np.array([[x, y, z, o, o, o], [o, x, o, y, z, o], [o, o, x, o, y, z]]), 2, 0)


@dataclass(frozen=True, eq=False)
class Chain:
    """A robot of named joints on a tree, with the base parameters that its torques depend on.

    A parameter that others are grouped into has an R in its name: ZZR1 is ZZ1 with what the bodies behind it add.
    """

    joints: tuple[str, ...]
    tree: Tree

    @property
    def rotary(self) -> tuple[bool, ...]:
        return tuple(bool(turn.any()) for turn in self.tree.turn)

    @property
    def gravity(self) -> tuple[float, float, float]:
        x, y, z = self.tree.gravity.tolist()
        return x, y, z

    @cached_property
    def base(self) -> tuple[tuple[int, ...], Array]:
        """Numbers of the columns that are kept, and shares (kept, 10 J) of each parameter of a body in them."""
        return _independent(_sample(self.tree), _order(len(self.tree)))

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        kept, shares = self.base
        out = []
        for column, share in zip(kept, shares, strict=True):
            body, name = divmod(column, 10)
            grouped = "R" if np.sum(np.abs(share) > _COUNTS) > 1 else ""
            symbol = _NAMES[name]
            out.append(Parameter(f"{symbol}{grouped}{body + 1}", self.joints[body], _UNITS[symbol]))
        return tuple(out)

    @cached_property
    def positive(self) -> tuple[str, ...]:
        """Those that nothing is grouped into, and that are moments of inertia or masses."""
        kept, _ = self.base
        named = zip(self.parameters, kept, strict=True)
        return tuple(p.name for p, column in named if _NAMES[column % 10] in _POSITIVE and "R" not in p.name)

    def regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        """q, dq, ddq (N, J) in rad or m and s -> (N, J, P)."""
        return self.tree.regressor(q, dq, ddq)[:, :, list(self.base[0])]

    # a body on the last link, and gravity from another side (`effects.load`) ---------------------------------------

    @cached_property
    def _carried(self) -> tuple[int, ...]:
        """Of the last body's columns, those that a load on it shows in."""
        last = 10 * (len(self.tree) - 1)
        kept, _ = _independent(_sample(self.tree)[:, last:], [_NAMES.index(name) for name in reversed(_NAMES)])
        return tuple(last + column for column in kept)

    @property
    def load_parameters(self) -> tuple[Parameter, ...]:
        names = [_NAMES[column % 10] for column in self._carried]
        return tuple(Parameter(name, None, _UNITS[name]) for name in names)

    def load_regressor(self, q: Array, dq: Array, ddq: Array) -> Array:
        """(N, J, k): torques per parameter of a body on the last link, in that link's frame."""
        return self.tree.regressor(q, dq, ddq)[:, :, list(self._carried)]

    def lean(self, q: Array, rigid: Array) -> Array:
        """(N, J, 3): torques per m/s^2 of gravity along each axis of the base, of the parameters (P,) there are.

        What gravity as the model has it never showed (the first moment of a body on a vertical axis) is not in them.
        """
        still, kept = np.zeros_like(q), list(self.base[0])
        parts = [self.tree.regressor(q, still, still, axis)[:, :, kept] @ rigid for axis in np.eye(3)]
        return np.stack(parts, axis=2)


def _order(bodies: int) -> list[int]:
    """Columns in the order in which they are kept: body by body from the base."""
    return [10 * i + _NAMES.index(name) for i in range(bodies) for name in _KEEP_FIRST]


def _sample(tree: Tree) -> Array:
    """Equations (R, 10 J) at random states."""
    random = np.random.default_rng(0)
    states = random.uniform(-2, 2, (3, _STATES, len(tree)))
    return tree.regressor(*states).reshape(-1, 10 * len(tree))


def _independent(W: Array, order: list[int]) -> tuple[tuple[int, ...], Array]:
    """Columns that do not depend on those before them, sorted; and the shares (kept, P) of all columns in them."""
    scale = np.linalg.norm(W, axis=0)
    basis = np.zeros((len(W), 0))
    kept = []
    largest = np.max(scale, initial=0.0)
    for column in order:
        if scale[column] <= _DEPENDS * largest:
            continue
        x = W[:, column] / scale[column]
        for _ in range(2):  # once more, against rounding
            x = x - basis @ (basis.T @ x)
        left = np.linalg.norm(x)
        if left > np.sqrt(_DEPENDS):
            basis = np.column_stack([basis, x / left])
            kept.append(column)
    kept.sort()
    shares = np.linalg.lstsq(W[:, kept], W)[0] if kept else np.zeros((0, W.shape[1]))
    return tuple(kept), np.asarray(shares)
