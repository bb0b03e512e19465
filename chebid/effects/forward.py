"""Effects acting in a simulation: their torque on one joint at one instant, compiled.

Every function takes (t, q, dq, ddq, tau, joint, p, h): time since the start of the record, the state (J,), the
model's own torque (J,), the joint whose torque is wanted, parameters p in the order of `symbols`, hyper-parameters h in
that of `Effect.vector`. It returns the torque; of dry friction the LEVEL, the torque being level * sign(dq) while
the joint moves and anything up to the level while it sticks.

One instant does not decide all of them: `presliding` remembers the last reversal (`BRISTLES`), elastic joints and gaps
need a plant with two masses (`TWO_MASSES`), and delay and clipping happen to the torque channel (`CHANNELS`). Effects
with no compiled form (formulas, other packages) act through `forward_form`, in Python.

This module imports numba and is imported by the simulator alone.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba import float64, int64, njit, types

from chebid.effects.channel import Saturation
from chebid.effects.effect import Effect
from chebid.effects.motion import Motion
from chebid.errors import UsageError
from chebid.robots import Array

_VECTOR = types.Array(float64, 1, "C")
#: (t, q, dq, ddq, tau, joint, p, h) -> torque or level
FORWARD = float64(float64, _VECTOR, _VECTOR, _VECTOR, _VECTOR, int64, _VECTOR, _VECTOR)


#: (q, way, h) -> z
BEND = float64(float64, float64, _VECTOR)


#: rad/s or m/s: what rubs with the speed of other joints creeps below it, since no stop of one joint would end it
CREEP = 1e-3


class Forward(NamedTuple):
    """`dry`: the function gives a level. An effect that grows with ddq does so linearly: it belongs to the mass."""

    function: Callable[..., float]
    dry: bool


# friction -------------------------------------------------------------------------------------------------------------


@njit(FORWARD, cache=True)
def viscous(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fv dq."""
    return p[0] * dq[joint]


@njit(FORWARD, cache=True)
def constant(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fs, a level; or Foff, a torque."""
    return p[0]


@njit(FORWARD, cache=True)
def viscous_asymmetry(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """dFv abs(dq)."""
    return p[0] * abs(dq[joint])


@njit(FORWARD, cache=True)
def stribeck(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Level Fst exp(-abs(dq/vs)^delta)."""
    return p[0] * math.exp(-((abs(dq[joint]) / h[0]) ** h[1]))


@njit(FORWARD, cache=True)
def viscous_quadratic(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """F2 dq abs(dq)."""
    return p[0] * dq[joint] * abs(dq[joint])


@njit(FORWARD, cache=True)
def viscous_power(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fa abs(dq)^alpha sign(dq): continuous at rest, though steep."""
    return p[0] * np.sign(dq[joint]) * abs(dq[joint]) ** h[0]


@njit(FORWARD, cache=True)
def load_friction(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Level mu abs(tau)."""
    return p[0] * abs(tau[joint])


@njit(FORWARD, cache=True)
def friction_ripple(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Level ac cos kq + as sin kq."""
    angle = h[0] * q[joint]
    return p[0] * math.cos(angle) + p[1] * math.sin(angle)


@njit(FORWARD, cache=True)
def coulomb_drift(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Level dFsT (1 - exp(-t/T))."""
    return -p[0] * math.expm1(-t / h[0])


@njit(FORWARD, cache=True)
def viscous_drift(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """dFvT (1 - exp(-t/T)) dq."""
    return -p[0] * math.expm1(-t / h[0]) * dq[joint]


# position -------------------------------------------------------------------------------------------------------------


@njit(FORWARD, cache=True)
def torque_ripple(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """bc cos kq + bs sin kq and harmonics."""
    total = 0.0
    for n in range(len(p) // 2):
        angle = (n + 1) * h[0] * q[joint]
        total += p[2 * n] * math.cos(angle) + p[2 * n + 1] * math.sin(angle)
    return total


@njit(FORWARD, cache=True)
def spring(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """k q - kq0, or k r tanh((q - q0) / r): what is not given is -inf."""
    if math.isinf(h[0]):
        return p[0] * q[joint] - p[1]
    rest = 0.0 if math.isinf(h[1]) else h[1]
    return p[0] * h[0] * math.tanh((q[joint] - rest) / h[0])


@njit(FORWARD, cache=True)
def cubic_spring(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """k3 (q - q0)^3."""
    return p[0] * (q[joint] - h[0]) ** 3


@njit(FORWARD, cache=True)
def hard_stop(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """kh s max(0, s (q - qs))^m."""
    inside = h[1] * (q[joint] - h[0])
    return p[0] * h[1] * inside ** h[2] if inside > 0 else 0.0


# transmission ---------------------------------------------------------------------------------------------------------


@njit(FORWARD, cache=True)
def rotor_inertia(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Ia ddq."""
    return p[0] * ddq[joint]


@njit(FORWARD, cache=True)
def viscous_coupling(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fv dq of the source."""
    return p[0] * dq[int(h[0])]


@njit(FORWARD, cache=True)
def coulomb_coupling(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fs sign(dq) of the source, but for creeping: not a level, it does not hold this joint."""
    return p[0] * math.tanh(dq[int(h[0])] / CREEP)


@njit(FORWARD, cache=True)
def motor_coupling(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """h = own joint, source, ratio: on either of the two joints."""
    own, source, ratio = int(h[0]), int(h[1]), h[2]
    way = math.tanh((dq[own] + ratio * dq[source]) / CREEP)
    if joint == own:
        return p[0] * ratio * ddq[source] + p[1] * ratio * dq[source] + p[2] * way
    return ratio * (p[0] * ddq[own] + p[1] * dq[own] + p[2] * way)


# load and channel -----------------------------------------------------------------------------------------------------


@njit(FORWARD, cache=True)
def payload_scara(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Eq. 18 with the changes of ZZR1, ZZ2, LMX2, LMY2, from t0 on."""
    if t < h[0]:
        return 0.0
    cosine, sine = math.cos(q[1]), math.sin(q[1])
    turning = p[1] * (ddq[0] + ddq[1])
    if joint == 1:
        first = ddq[0] * cosine + dq[0] ** 2 * sine
        return turning + p[2] * first + p[3] * (dq[0] ** 2 * cosine - ddq[0] * sine)
    both, coriolis = 2 * ddq[0] + ddq[1], dq[1] * (2 * dq[0] + dq[1])
    carried = p[2] * (both * cosine - coriolis * sine) - p[3] * (both * sine + coriolis * cosine)
    return p[0] * ddq[0] + turning + carried


@njit(FORWARD, cache=True)
def payload_axes(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Changes of every inertia, from t0 on."""
    return p[joint] * ddq[joint] if t >= h[0] else 0.0


@njit(FORWARD, cache=True)
def base_tilt_scara(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """G1c cos q1 + G1s sin q1 on joint 1, G2c cos(q1 + q2) + G2s sin(q1 + q2) on both."""
    both = q[0] + q[1]
    second = p[2] * math.cos(both) + p[3] * math.sin(both)
    return second if joint == 1 else second + p[0] * math.cos(q[0]) + p[1] * math.sin(q[0])


@njit(FORWARD, cache=True)
def external_push(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """P (1 + cos(pi (t - t0)/width))/2 near t0."""
    x = (t - h[0]) / h[1]
    return 0.5 * p[0] * (1 + math.cos(math.pi * x)) if abs(x) < 1 else 0.0


@njit(FORWARD, cache=True)
def torque_gain(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """g tau."""
    return p[0] * tau[joint]


#: name (`Effect.forward`) -> compiled form
FORWARDS: dict[str, Forward] = {
    "viscous": Forward(viscous, False),
    "coulomb": Forward(constant, True),
    "offset": Forward(constant, False),
    "viscous_asymmetry": Forward(viscous_asymmetry, False),
    "stribeck": Forward(stribeck, True),
    "viscous_quadratic": Forward(viscous_quadratic, False),
    "viscous_power": Forward(viscous_power, False),
    "load_friction": Forward(load_friction, True),
    "friction_ripple": Forward(friction_ripple, True),
    "coulomb_drift": Forward(coulomb_drift, True),
    "viscous_drift": Forward(viscous_drift, False),
    "torque_ripple": Forward(torque_ripple, False),
    "spring": Forward(spring, False),
    "cubic_spring": Forward(cubic_spring, False),
    "hard_stop": Forward(hard_stop, False),
    "rotor_inertia": Forward(rotor_inertia, False),
    "viscous_coupling": Forward(viscous_coupling, False),
    "coulomb_coupling": Forward(coulomb_coupling, False),
    "motor_coupling": Forward(motor_coupling, False),
    "payload_scara": Forward(payload_scara, False),
    "payload_axes": Forward(payload_axes, False),
    "base_tilt_scara": Forward(base_tilt_scara, False),
    "external_push": Forward(external_push, False),
    "torque_gain": Forward(torque_gain, False),
}


# what needs more than an instant --------------------------------------------------------------------------------------


@njit(BEND, cache=True)
def bend(q, way, h):  # type: ignore[no-untyped-def]
    """Dahl's z at q, moving `way` (1, -1; 0 at rest) since the joint stood at h[1] with the bend h[2]; h[0]: delta."""
    return h[2] if way == 0.0 else way - (way - h[2]) * math.exp(-abs(q - h[1]) / h[0])


@njit(FORWARD, cache=True)
def presliding(t, q, dq, ddq, tau, joint, p, h):  # type: ignore[no-untyped-def]
    """Fps z; the rest of the effect, -Fps sign(dq), is a level."""
    return p[0] * bend(q[joint], np.sign(dq[joint]), h)


#: name -> torque of the bent bristle, of h = [delta, q and z at the last stop]; besides it there is a level of -p[0]
BRISTLES: dict[str, Callable[..., float]] = {"presliding": presliding}
#: these need a plant with a motor and a link on their joint
TWO_MASSES = ("joint_flexibility", "backlash")


def _delayed(t: Array, tau: Array, effect: Effect, p: Array) -> Array:
    return np.column_stack([np.interp(t - p[0], t, column) for column in tau.T])


def _clipped(t: Array, tau: Array, effect: Effect, p: Array) -> Array:
    assert isinstance(effect, Saturation)
    out = tau.copy()
    out[:, effect.joint] = np.clip(tau[:, effect.joint], -effect.limit, effect.limit)
    return out


#: name -> (t (N,), torque (N, J), effect, p) -> what the torque channel makes of it (N, J)
CHANNELS: dict[str, Callable[[Array, Array, Effect, Array], Array]] = {"torque_delay": _delayed, "saturation": _clipped}


def forward_form(effect: Effect, rigid: Array | None = None) -> Forward:
    """The compiled form of an effect (bound to its robot), else one in Python: 100 times slower, for any effect.

    `rigid` (P,): the robot's parameters, where the effect depends on them. Raises UsageError for an effect that one
    instant does not decide.
    """
    if effect.forward in FORWARDS:
        return FORWARDS[effect.forward]
    if effect.memory or effect.name in CHANNELS:
        raise UsageError(
            f"{effect.name} has no torque at a single instant", hint="leave it out of the model to be simulated"
        )
    return Forward(_in_python(effect, rigid), False)


def _in_python(effect: Effect, rigid: Array | None) -> Callable[..., float]:
    rows: dict[int, dict[int, int]] = {}

    def function(t: float, q: Array, dq: Array, ddq: Array, tau: Array, joint: int, p: Array, h: Any) -> float:
        at = rows.setdefault(len(q), {row: i for i, row in enumerate(effect.rows(len(q)))})
        if joint not in at:
            return 0.0
        motion = Motion(np.array([t]), q[None], dq[None], ddq[None], tau[None], rigid)
        return float(effect.on(motion)[0, at[joint]] @ p)

    return function
