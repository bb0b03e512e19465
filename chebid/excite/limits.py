"""How far, how fast and how hard each joint may go."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from chebid.errors import InputError, Place
from chebid.model import Model, per_joint
from chebid.robots import Array, urdf_limits

_POWER = 60  # of the norm: within 7 % of the maximum of 60 shares
_MARGIN = 1 - 1e-9  # rounding


@dataclass(frozen=True)
class Limits:
    """Largest position, velocity, acceleration of each joint (J,): rad or m, and s."""

    position: Array
    velocity: Array
    acceleration: Array

    def stacked(self) -> Array:
        """(3, J)."""
        return np.stack([self.position, self.velocity, self.acceleration])

    def used(self, state: Array) -> Array:
        """(3, J): share of each limit that a motion (3, N, J) reaches."""
        return np.abs(state).max(axis=1) / self.stacked()


def full_size(shares: Array, amplitude: Array) -> tuple[Array, Callable[[Array], tuple[Array, Array]]]:
    """How much larger (J,) a motion may be that uses these shares (K, J) of its limits, times 1/(1 + exp(-amplitude)).

    The largest share is replaced by a p-norm, which is smooth and not below it. Returns the size, and the function
    that turns a gradient by it (J,) into gradients by the shares and by the amplitude (J,).
    """
    top = shares.max(axis=0)
    sums = ((shares / top) ** _POWER).sum(axis=0)
    part = expit(amplitude)
    size = _MARGIN * part / (top * sums ** (1 / _POWER))

    def pull(by_size: Array) -> tuple[Array, Array]:
        by_shares = -by_size * size * (shares / top) ** (_POWER - 1) / (sums * top)
        return by_shares, by_size * size * (1 - part)

    return size, pull


def make_limits(model: Model) -> Limits:
    """The limits of a model file; of a URDF, positions and velocities that the model file leaves out.

    Raises InputError without them, or when one is zero.
    """
    section, where = model.limits, Place(str(model.path), key="limits")
    if section is None:
        raise InputError(
            "has no limits",
            hint="add them to the model file, such as 'limits: {position: [1.5, 2.2], velocity: [4, 8], "
            "acceleration: [12, 40]}'",
            place=where,
        )
    count = len(model.joints)
    given = {name: getattr(section, name) for name in ("position", "velocity", "acceleration")}
    known = urdf_limits(model) if None in given.values() and model.robot.type == "urdf" else {}
    position, velocity, acceleration = (
        known.get(name, np.full(count, np.inf)) if value is None else np.array(per_joint(value, count), dtype=float)
        for name, value in given.items()
    )
    limits = Limits(position, velocity, acceleration)
    if not np.isfinite(limits.stacked()).all():
        word = ("position", "velocity")[int(np.isfinite(position).all())]
        hint = f"add {word}: to limits:, one number or one per joint"
        raise InputError(f"has no limit of {word} for every joint", hint=hint, place=where)
    if not (limits.stacked() > 0).all():
        raise InputError("a limit of 0 allows no motion", hint="give positive limits", place=where)
    return limits
