"""Springs and gaps between motors and links, for the simulator: two masses on a joint instead of one.

    B ddq_m + friction + f(q_m - q_l, dq_m - dq_l) = u,    f = the rigid model's torque at q_l, less B ddq_l

with f = K delta + D delta', within a gap 0 and beyond it a stiff contact. The encoder sees the motor, and every other
effect acts on it. Source: Spong,
Modeling and control of elastic joint robots, J. Dyn. Sys. Meas. Control 109 (1987), eq. 8 and 9; the contact: any stiff
one, since only the gap is known.

The rotor B is `rotor_inertia` where the model has it, on top of the rigid inertias. Elsewhere it is part of them, and
no motion can tell how much: a share `ROTOR` of the joint's inertia, which the user is told. That share does not hang on
the spring, so that a compliance found as if all of it did (the column of `joint_flexibility`) comes out smaller by it.
"""

from dataclasses import dataclass

import numpy as np
import scipy.optimize
from numpy.typing import NDArray

from chebid.dynamics import Dynamics
from chebid.errors import InputError, Notice, Place
from chebid.model import Model
from chebid.robots import Array

CONTACT = 150.0  # Hz: own frequency of a link in contact with its motor, which stands still
DAMPING = 0.1  # of the critical, of a link on its spring: harmonic drives have 0.02 to 0.1
ROTOR = 0.2  # share of a joint's inertia that is its motor's where the model does not say
_CONTACT_DAMPING = 0.3
_MOVES = ("payload", "base_tilt")  # effects on the links, which the simulator would put on the motors
_RESTS = 1e-6  # of the load at first: what is left of it at rest
_STIFF = 5e3  # Hz: a motor that would swing faster against its link is taken to be stiff
_LOOKS = 200  # positions at which the inertia is looked at


@dataclass(frozen=True)
class Transmission:
    """How the motors of an arm with J joints drive their links.

    `link` (J,): the number of the joint's link among n masses, its own where the joint is stiff; `hung` (4, J):
    stiffness, damping, gap, and what of the joint's rigid inertia is its motor's; 0 where it is stiff.
    """

    link: NDArray[np.int64]
    hung: Array
    notices: tuple[Notice, ...]

    @property
    def masses(self) -> int:
        """n."""
        return int(max(len(self.link), self.link.max(initial=0) + 1))

    def widened(self, x: Array, fill: float) -> Array:
        """Of every joint (..., J) made of every mass (..., n): `fill` for the links."""
        more = self.masses - x.shape[-1]
        return np.concatenate([x, np.full((*x.shape[:-1], more), fill)], axis=-1)

    def start(self, dynamics: Dynamics, theta: Array, motors: Array) -> Array:
        """Positions and velocities (2, n): of motors (2, J) that are there, and of links at rest on their springs.

        Links that find no rest start where their motors are, and swing.
        """
        hangs = np.flatnonzero(self.link != np.arange(len(self.link)))
        q = motors[0].copy()

        def unbalance(links: Array) -> Array:
            """Torque of the transmissions less that of the links at rest."""
            q[hangs] = links
            load = dynamics.robot.regressor(q[None], np.zeros((1, len(q))), np.zeros((1, len(q))))[0]
            ahead, half = motors[0, hangs] - links, self.hung[2, hangs] / 2
            torque = self.hung[0, hangs] * (ahead - np.clip(ahead, -half, half))
            return np.asarray(torque - (load @ dynamics.rigid(theta))[hangs])

        links = motors[:, hangs].copy()
        if hangs.size and np.any(unbalance(links[0])):
            found = scipy.optimize.root(unbalance, links[0], method="lm", options={"xtol": 1e-12})
            if np.abs(unbalance(found.x)).max() < _RESTS * np.abs(unbalance(motors[0, hangs])).max():
                links[0] = found.x
        return np.ascontiguousarray(np.concatenate([motors, links], axis=1))


def transmission(model: Model, dynamics: Dynamics, theta: Array, q: Array) -> Transmission:
    """From the springs and gaps of a model with parameters theta (P,); q (N, J): where the arm goes.

    Raises InputError for a rotor whose inertia is not positive, and for effects on the links beside a spring or a gap.
    """
    count = len(dynamics.joints)
    named = {(effect.name, effect.joint): p for effect, p in dynamics.terms(theta)}
    link, hung, notices, last = np.arange(count), np.zeros((4, count)), [], count
    for j, name in enumerate(dynamics.joints):
        given = [float(named.get((key, j), [0])[0]) for key in ("joint_flexibility", "backlash")]
        if min(given) < 0:
            text = f"{name}: its compliance or gap is below zero, and is taken to be none"
            notices.append(Notice("stiff_joint", text, Place(str(model.path), key="fit")))
        compliance, gap = (max(value, 0.0) for value in given)
        if compliance == gap == 0:
            continue
        _check(model, dynamics, named, j)
        inertia = float(_inertia(dynamics, theta, q[:: max(1, len(q) // _LOOKS)], j).min())
        share = 0.0 if ("rotor_inertia", j) in named else ROTOR
        ratio = DAMPING if compliance else _CONTACT_DAMPING
        own = (1 - share) * inertia
        stiffness = 1 / compliance if compliance else own * (2 * np.pi * CONTACT) ** 2
        rotor = share * inertia or float(named["rotor_inertia", j][0])
        if stiffness * (1 / own + 1 / rotor) > (2 * np.pi * _STIFF) ** 2:
            text = f"{name}: its spring is stiffer than any that a drive excites, and is taken to be none"
            notices.append(Notice("stiff_joint", text, Place(str(model.path), key="fit")))
            continue
        if share:
            text = (
                f"{name}: {100 * share:.0f} % of its inertia are taken to be its motor's, {share * inertia:.3g} in SI"
            )
            notices.append(Notice("assumed_rotor", text, Place(str(model.path), key="effects")))
        hung[:, j] = stiffness, 2 * ratio * np.sqrt(stiffness * own), gap, share * inertia
        link[j], last = last, last + 1
    return Transmission(link, hung, tuple(notices))


def _check(model: Model, dynamics: Dynamics, named: dict[tuple[str, int | None], Array], joint: int) -> None:
    name, place = dynamics.joints[joint], Place(str(model.path), key="effects")
    rotor = named.get(("rotor_inertia", joint))
    if rotor is not None and not rotor[0] > 0:
        raise InputError(
            f"{name} has a spring or a gap behind a motor of inertia {rotor[0]:.3g}",
            hint="give its Ia a value above 0, or leave rotor_inertia out of a copy of the model file",
            place=place,
        )
    for effect, _ in named:
        if effect in _MOVES:
            raise InputError(
                f"{effect} acts on the links, and {name} has a spring or a gap before its link",
                hint="leave one of the two out of a copy of the model file",
                place=place,
            )


def _inertia(dynamics: Dynamics, theta: Array, q: Array, joint: int) -> Array:
    """What a joint feels at positions q (N, J) while the others are free, (N,) in kg.m^2 or kg: 1 / (M^-1)_jj.

    What is taken from it may be taken from the rigid inertia without making it indefinite.
    """
    units = np.eye(q.shape[1])
    ddq = np.concatenate([np.zeros_like(units[:1]), units])
    state = (np.repeat(q, len(ddq), axis=0), np.zeros((len(q) * len(ddq), q.shape[1])), np.tile(ddq, (len(q), 1)))
    torque = (dynamics.robot.regressor(*state) @ dynamics.rigid(theta)).reshape(len(q), len(ddq), -1)
    mass = torque[:, 1:] - torque[:, :1]
    free = np.linalg.pinv(mass, hermitian=True)[:, joint, joint]  # what is indefinite is told by the simulation
    return np.asarray(1 / np.maximum(free, np.finfo(float).tiny))
