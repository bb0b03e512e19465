"""The quantities an error may depend on, at the samples of a motion, with no physics assumed."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.effects import Motion

Values = Callable[[Motion, Array], Array]
_HATS, _FINE = 8, 20  # what comes and goes several times in a log needs more than what drifts


@dataclass(frozen=True)
class Variable:
    """`name` for a person; `x` (N,) from a motion and the model's torque (N, J); `times` (N,) multiplies the error.

    `hats`: how many functions of x; one name may stand for a coarse and a fine variable.
    """

    name: str
    x: Values
    times: Values | None = None
    hats: int = _HATS

    @property
    def accelerates(self) -> bool:
        """Whether it has the noise of accelerations in it."""
        return "ddq" in self.name or "tau" in self.name


def variables(joint: int, joints: tuple[str, ...]) -> list[Variable]:
    """What the error of one joint may depend on; names of other joints stand in brackets."""
    j = joint
    sign: Values = lambda m, _: np.sign(m.dq[:, j])  # noqa: E731
    speed: Values = lambda m, _: m.dq[:, j]  # noqa: E731
    own = [
        Variable("q", lambda m, _: m.q[:, j]),
        Variable("dq", speed),
        Variable("ddq", lambda m, _: m.ddq[:, j]),
        Variable("t", lambda m, _: m.t),
        Variable("t", lambda m, _: m.t, hats=_FINE),
        Variable("tau", lambda _, tau: tau[:, j]),
        Variable("q*sign(dq)", lambda m, _: m.q[:, j], sign),
        Variable("q*dq", lambda m, _: m.q[:, j], speed),
        Variable("t*sign(dq)", lambda m, _: m.t, sign),
        Variable("t*sign(dq)", lambda m, _: m.t, sign, _FINE),
        Variable("t*dq", lambda m, _: m.t, speed),
        Variable("abs(tau)*sign(dq)", lambda _, tau: np.abs(tau[:, j]), sign),
        Variable("abs(tau)*dq", lambda _, tau: np.abs(tau[:, j]), speed),
        Variable("distance since reversal", lambda m, _: np.log(1e-9 + since_reversal(m, j)), sign),
    ]
    return own + [other for i, name in enumerate(joints) if i != j for other in _coupled(i, name, sign, speed)]


def _coupled(i: int, name: str, sign: Values, speed: Values) -> list[Variable]:
    """What another joint may do to the error."""
    return [
        Variable(f"q[{name}]", lambda m, _: m.q[:, i]),
        Variable(f"dq[{name}]", lambda m, _: m.dq[:, i]),
        Variable(f"ddq[{name}]", lambda m, _: m.ddq[:, i]),
        Variable(f"tau[{name}]", lambda _, tau: tau[:, i]),
        Variable(f"q[{name}]*sign(dq)", lambda m, _: m.q[:, i], sign),
        Variable(f"q[{name}]*dq", lambda m, _: m.q[:, i], speed),
        Variable(f"abs(tau[{name}])*sign(dq)", lambda _, tau: np.abs(tau[:, i]), sign),
        Variable(f"abs(dq[{name}])*sign(dq)", lambda m, _: np.abs(m.dq[:, i]), sign),
    ]


def since_reversal(motion: Motion, joint: int) -> Array:
    """Distance (N,) that a joint has gone since its direction changed, rad or m."""
    q = motion.q[:, joint]
    return np.abs(q - q[_last_reversal(motion, joint)])


def time_since_reversal(motion: Motion, joint: int) -> Array:
    """Time (N,) since a joint's direction changed, s; infinite before it first does."""
    last = _last_reversal(motion, joint)
    return np.where(last > 0, motion.t - motion.t[last], np.inf)


def _last_reversal(motion: Motion, joint: int) -> NDArray[np.int64]:
    """Index (N,) of the sample at which the direction last changed; 0 before."""
    sign = np.sign(motion.dq[:, joint])
    turned = np.flatnonzero(sign[1:] * sign[:-1] < 0) + 1
    return np.concatenate([[0], turned])[np.searchsorted(turned, np.arange(len(sign)), side="right")]


def hats(x: Array, low: float, high: float, count: int) -> Array:
    """Hat functions (N, count) with equal steps from low to high, those at the ends going on beyond."""
    place = np.clip((x - low) / max(high - low, np.finfo(float).tiny), 0.0, 1.0) * (count - 1)
    return np.maximum(0.0, 1 - np.abs(place[:, None] - np.arange(count)))
