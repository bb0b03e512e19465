"""Backlash and joint flexibility, told apart by simulating a link that hangs on its motor.

The motor moves as logged; its link lags by delta(t), which the transmission's torque f brings back (two masses, the
motor's motion given; Spong, J. Dyn. Sys. Meas. Control 109, 1987):

    M(t) delta'' + f(delta, delta') = tau(t)

M(t): the inertia that the rigid model has at this joint; tau(t): the rigid torque that moves the link as the motor
moves. A spring: f = K delta + D delta'. A gap: the same, stiff, beyond +-gap/2, and nothing within. The joint's torque
differs from the rigid one by f - tau, that of the others by -M_ij delta''.
"""

from collections.abc import Container, Iterable, Iterator
from dataclasses import dataclass, field

import numpy as np

from chebid.basis import Array
from chebid.critique.evidence import Evidence, Judged
from chebid.dynamics import Dynamics
from chebid.effects import Effect, Motion
from chebid.effects.transmission import Backlash, JointFlexibility

_STEP = 1e-3  # s, at most
_SPRINGS = np.geomspace(3.0, 40.0, 9)  # Hz: own frequency of the link on its spring
_GAPS = np.geomspace(1e-4, 0.03, 9)  # of the range of the joint
_CONTACT = 60.0  # Hz: own frequency in contact, beyond what the equations see
_SPRING_DAMPING, _CONTACT_DAMPING = 0.1, 0.5  # of the critical
_SOFT = 0.15  # of the rms torque: over which the signature of a gap changes sides
_SIZE, _SPREAD = (0.3, 3.0), 0.3  # of what a spring adds, in what was simulated: what is credible, and its deviation
_FLIES = 1e3  # times the largest torque of the link: no transmission bears that


@dataclass(frozen=True)
class Hang:
    """How a link hangs on its motor: (K,) springs of `frequency` Hz, or gaps (rad or m) that a contact closes."""

    frequency: Array
    gap: Array

    @property
    def damping(self) -> Array:
        """Share of the critical damping (K,)."""
        return np.where(self.gap > 0, _CONTACT_DAMPING, _SPRING_DAMPING)

    def single(self, k: int) -> "Hang":
        """The k-th alone."""
        return Hang(self.frequency[k : k + 1], self.gap[k : k + 1])


def families(evidence: Evidence, kinds: Container[str], joints: Iterable[int]) -> Iterator[list[Judged]]:
    """Those of springs and gaps that are among `kinds`, on every one of the joints that has none yet."""
    for joint in joints:
        for kind, hang in ((JointFlexibility, _springs(_SPRINGS)), (Backlash, _gaps(_GAPS * _reach(evidence, joint)))):
            if kind.name in kinds and (kind.name, joint) not in evidence.present:
                yield from judged_hangs(evidence, joint, hang)


def refined_hang(evidence: Evidence, judged: Judged) -> Judged:
    """The spring or gap between the neighbours of one that was tried which explains the logs best."""
    effect = judged.effect
    assert isinstance(effect, HangingSpring | HangingGap), "one of `families`"
    around = np.geomspace(0.7, 1.45, 9)
    hang = _springs(effect.own * around) if isinstance(effect, HangingSpring) else _gaps(effect.own * around)
    return max([judged, *judged_hangs(evidence, effect.joint, hang)[effect.slow]], key=lambda one: one.gain)


@dataclass(frozen=True)
class Hanging:
    """What the simulation found: `own`, the link's own frequency in Hz on a spring, or the gap in rad or m.

    `slow`: only equations within the bandwidth of the positions have it, beyond which accelerations are noise.
    """

    own: float = field(default=0.0, kw_only=True, compare=False)
    slow: bool = field(default=False, kw_only=True, compare=False)


@dataclass(frozen=True)
class HangingSpring(Hanging, JointFlexibility):
    """Joint flexibility as it was simulated."""

    @property
    def hang(self) -> Hang:
        return _springs(np.array([self.own]))


@dataclass(frozen=True)
class HangingGap(Hanging, Backlash):
    """Backlash as it was simulated."""

    @property
    def hang(self) -> Hang:
        return _gaps(np.array([self.own]))


def judged_hangs(evidence: Evidence, joint: int, hang: Hang) -> tuple[list[Judged], list[Judged]]:
    """Every spring or gap as a candidate: on all equations, and on the slow ones."""
    rows = _rows(evidence, joint, hang)
    slow = _slow(evidence, rows)
    each = range(rows.shape[1])
    return (
        [_judge(evidence, joint, hang.single(k), False, rows[:, [k]]) for k in each],
        [_judge(evidence, joint, hang.single(k), True, slow[:, [k]]) for k in each],
    )


def simulated_rows(evidence: Evidence, effect: Effect) -> Array:
    """Whitened rows (R, k) of an effect: of a spring or gap what its simulation adds, of others their columns."""
    if not isinstance(effect, HangingSpring | HangingGap):
        return evidence.columns(effect)
    rows = _rows(evidence, effect.joint, effect.hang)
    return _slow(evidence, rows) if effect.slow else rows


def simulated_block(dynamics: Dynamics, effect: Effect, motion: Motion, theta: Array) -> Array:
    """The same over time (N, J, k), under parameters theta (P,) of the model without the effect."""
    if not isinstance(effect, HangingSpring | HangingGap):
        return dynamics.block(effect, dynamics.prepare(motion, theta))
    return _torques(dynamics, theta, motion, effect.joint, effect.hang)


def simulated_size(evidence: Evidence, effect: Effect) -> float | None:
    """Parameter of a spring (its compliance) or gap that was simulated, None of other effects."""
    if isinstance(effect, HangingGap):
        return effect.own
    if not isinstance(effect, HangingSpring):
        return None
    inertia = np.concatenate([mass[:, effect.joint, effect.joint] for mass in evidence.mass])
    return float(1 / ((2 * np.pi * effect.own) ** 2 * np.median(inertia)))


def _rows(evidence: Evidence, joint: int, hang: Hang) -> Array:
    columns = [_torques(evidence.dynamics, evidence.theta, motion, joint, hang) for motion in evidence.motions]
    return evidence.project(columns)


def _slow(evidence: Evidence, rows: Array) -> Array:
    """Rows (R, K) of the equations that lie within the bandwidth of the positions, zeros for the others."""
    below = evidence.rows.frequency <= evidence.ground.problem.bandwidth
    return rows * evidence.padded(below)[:, None]


def _judge(evidence: Evidence, joint: int, hang: Hang, slow: bool, rows: Array) -> Judged:
    """A spring must add about what it was simulated to add: below its own frequency all look alike but for the size.

    (Not a gap, whose impacts ring at other instants than those of the arm; nor what is left of it on slow equations.)
    """
    effect = _effect(evidence, joint, hang, slow)
    basis = evidence.beside(rows) if np.any(rows) else rows[:, :0]
    along, residual = (float(basis[:, 0] @ x) if basis.shape[1] else 0.0 for x in (rows[:, 0], evidence.residual))
    size = residual / along if along else 0.0
    gap = hang.gap[0] > 0
    if not (size > 0 if gap or slow else _SIZE[0] < size < _SIZE[1]):
        return Judged(effect, np.zeros((len(rows), 0)), 0.0)
    if gap or slow:
        return Judged(effect, basis, residual**2)
    # least squares with a size of 1 +- _SPREAD known beforehand
    known = 1 / _SPREAD**2
    best = (along * residual + known) / (along**2 + known)
    return Judged(effect, basis, 2 * best * along * residual - (best * along) ** 2 - known * (best - 1) ** 2)


def _effect(evidence: Evidence, joint: int, hang: Hang, slow: bool) -> Effect:
    gap = float(hang.gap[0])
    if not gap:
        return HangingSpring(joint, own=float(hang.frequency[0]), slow=slow)
    tau = evidence.trusted.tau
    assert tau is not None, "the evidence gives the model's torque"
    rms = float(np.sqrt(np.mean(tau[:, joint] ** 2))) or 1.0
    return HangingGap(joint, soft=_SOFT * rms, own=gap, slow=slow)


def _springs(frequency: Array) -> Hang:
    return Hang(frequency, np.zeros(len(frequency)))


def _gaps(gap: Array) -> Hang:
    return Hang(np.full(len(gap), _CONTACT), gap)


def _reach(evidence: Evidence, joint: int) -> float:
    return float(np.ptp(evidence.trusted.q[:, joint]))


def _torques(dynamics: Dynamics, parameters: Array, motion: Motion, joint: int, hang: Hang) -> Array:
    """What each transmission (K,) adds to the rigid torques: (N, J, K)."""
    robot, theta = dynamics.robot, dynamics.rigid(parameters)
    rigid = robot.regressor(motion.q, motion.dq, motion.ddq) @ theta
    more = motion.ddq.copy()
    more[:, joint] += 1.0
    inertia = robot.regressor(motion.q, motion.dq, more) @ theta - rigid
    own = np.maximum(inertia[:, joint], 1e-3 * np.median(np.abs(inertia[:, joint])))
    torque, bend = _lag(motion.t, own, rigid[:, joint], hang)
    out = -inertia[:, :, None] * bend[:, None, :]
    out[:, joint] = torque - rigid[:, [joint]]
    return out


def _lag(t: Array, inertia: Array, torque: Array, hang: Hang) -> tuple[Array, Array]:
    """Torque of the transmission and delta'' (N, K)."""
    from chebid.simulate.hanging import march

    steps = max(1, int(np.ceil(float(np.median(np.diff(t))) / _STEP)))
    w = 2 * np.pi * hang.frequency
    stiffness, damping = w**2 * np.median(inertia), 2 * hang.damping * w * np.median(inertia)
    force, bend = np.empty((2, len(t), len(w)))
    t, inertia, torque = (np.ascontiguousarray(x, dtype=np.float64) for x in (t, inertia, torque))
    march(t, inertia, torque, stiffness, damping, hang.gap, steps, force, bend)
    # an inertia that the fit made next to nothing flies off: what it says is nothing
    gone = ~(np.abs(force).max(axis=0) < _FLIES * max(float(np.abs(torque).max()), np.finfo(float).tiny))
    force[:, gone], bend[:, gone] = torque[:, None], 0.0
    return force, bend
