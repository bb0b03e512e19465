"""A robot to be measured: its physics is MuJoCo's, its logs are what a drive would have written.

Nothing here comes from chebid. A world is a planar arm of two links (SCARA) or independent axes, with dry friction that
really holds a joint still, moved by a PD law at its own rate. One run gives the state at every step of the physics;
sensors make a log of it. The torque of the motors enters as generalised forces, and whatever else acts on a joint
(the hidden effects) through the hooks of `tests/blind/effects.py`.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

Array = np.ndarray
STEP = 5e-4  # s, of the physics; halving it changes torques by far less than any noise drawn here (test_world.py)
HOLD = 1.0  # s before the log begins, for transients of the start to die out
# Dry friction is a constraint in MuJoCo: it saturates at its full value above some 1e-7 rad/s and creeps below.
_STICTION = 'solreffriction="{tc} 1" solimpfriction="0.9999 0.9999 0.001 0.5 2"'
_NEVER_ZERO = 1e-9  # a joint without friction loss gets no constraint, and none can be switched on later


@dataclass(frozen=True)
class Transmission:
    """What stands between motor and link: a spring (N.m/rad, N.m.s/rad), or a gap (rad) with nothing in it."""

    rotor: float
    stiffness: float = 0.0
    damping: float = 0.0
    gap: float = 0.0


@dataclass(frozen=True)
class Link:
    """One driven joint and the body it moves; SI units, centre of mass in the frame of the joint."""

    mass: float
    inertia: float
    com: tuple[float, float] = (0.0, 0.0)
    length: float = 0.0
    armature: float = 0.0
    damping: float = 0.0
    friction: float = 0.0
    transmission: Transmission | None = None


@dataclass(frozen=True)
class Arm:
    """A `scara` (links one behind the other) or `axes` (each on its own), with its controller."""

    kind: str
    links: tuple[Link, ...]
    kp: tuple[float, ...]
    kd: tuple[float, ...]
    prismatic: tuple[bool, ...] = (False, False)
    period: float = 1e-3  # s, of the control
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limit: tuple[float, ...] = ()  # N.m, at which the drive really clips

    @property
    def joints(self) -> int:
        return len(self.links)

    def with_link(self, joint: int, **changes: Any) -> "Arm":
        links = list(self.links)
        links[joint] = replace(links[joint], **changes)
        return replace(self, links=tuple(links))


class Motion(Protocol):
    """Reference positions and velocities (K, J) at times (K,); negative times come before the log."""

    def __call__(self, t: Array) -> tuple[Array, Array]: ...


@dataclass
class Physics:
    """What a hook sees of the running engine: per driven joint, and the engine itself."""

    model: Any
    data: Any
    drive: list[int]
    step: float


# hook(t, q, dq, motor, push, loss) adds to push (torque on each joint) and loss (dry friction of each joint), in place
Hook = Callable[[float, list[float], list[float], list[float], list[float], list[float]], None]


@dataclass(frozen=True)
class Run:
    """The exact state at every step: t (K,), q, dq and motor torque (K, J); motor[k] acts from t[k] to t[k+1]."""

    t: Array
    q: Array
    dq: Array
    motor: Array
    step: float
    reference: Array
    ddq: Array = field(init=False)

    def __post_init__(self) -> None:
        # the semi-implicit Euler step is dq[k+1] = dq[k] + h ddq[k]: nothing is lost by this difference
        ddq = np.diff(self.dq, axis=0, append=self.dq[-1:]) / self.step
        object.__setattr__(self, "ddq", ddq)


def xml(arm: Arm, step: float = STEP) -> str:
    """The arm in MuJoCo's own language; z is up, all joints turn about z or slide along x."""
    gravity = " ".join(map(repr, arm.gravity))
    bodies, closing = "", ""
    for number, link in enumerate(arm.links):
        chained = arm.kind == "scara" and number
        place = f"{arm.links[number - 1].length!r} 0 0" if chained else f"0 {0 if arm.kind == 'scara' else number} 0"
        if number and not chained:
            bodies, closing = bodies + closing, ""
        opened, ends = _body(number, link, arm.prismatic[number], place, step)
        bodies, closing = bodies + opened, ends + closing
    return (
        f'<mujoco><compiler angle="radian"/><option timestep="{step!r}" gravity="{gravity}" integrator="Euler" '
        'tolerance="1e-12"><flag eulerdamp="disable" contact="disable"/></option>'
        f"<worldbody>{bodies}{closing}</worldbody></mujoco>"
    )


def _body(number: int, link: Link, slides: bool, place: str, step: float) -> tuple[str, str]:
    """Opening and closing tags of a link, with a rotor before it when there is something between the two."""
    kind = 'type="slide" axis="1 0 0"' if slides else 'type="hinge" axis="0 0 1"'
    soft = _STICTION.format(tc=2 * step)
    joint = (
        f'<joint name="q{number}" {kind} damping="{link.damping!r}" armature="{link.armature!r}" '
        f'frictionloss="{max(link.friction, _NEVER_ZERO)!r}" {soft}/>'
    )
    x, y = link.com
    inertial = (
        f'<inertial pos="{x!r} {y!r} 0" mass="{link.mass!r}" diaginertia="{" ".join([repr(link.inertia)] * 3)}"/>'
    )
    gear = link.transmission
    if gear is None:
        return f'<body name="b{number}" pos="{place}" simple="false">{joint}{inertial}', "</body>"
    rotor_mass = gear.rotor if slides else 1e-4
    rotor_inertia = 1e-6 if slides else gear.rotor
    rotor = f'<inertial pos="0 0 0" mass="{rotor_mass!r}" diaginertia="{" ".join([repr(rotor_inertia)] * 3)}"/>'
    between = f'<joint name="r{number}" {kind} stiffness="{gear.stiffness!r}" damping="{gear.damping!r}" '
    if gear.gap:
        stop = f'solreflimit="{4 * step!r} 0.7" solimplimit="0.99 0.99 0.001 0.5 2"'
        between += f'limited="true" range="{-gear.gap / 2!r} {gear.gap / 2!r}" {stop} '
    head = f'<body name="m{number}" pos="{place}">{joint}{rotor}<body name="b{number}" simple="false">'
    return f"{head}{between}/>{inertial}", "</body></body>"


def run(
    arm: Arm,
    motion: Motion,
    duration: float,
    start: Callable[[Physics], Sequence[Hook]] = lambda physics: (),
    step: float = STEP,
    stretch: float = 0.05,
) -> Run:
    """Follow a motion under PD control for `duration` seconds, from rest at HOLD seconds before.

    The run reaches `stretch` seconds past both ends of the log. Raises FloatingPointError when the arm does not
    follow (the simulation diverged).
    """
    import mujoco

    model = mujoco.MjModel.from_xml_string(xml(arm, step))
    data = mujoco.MjData(model)
    drive = [int(model.joint(f"q{j}").dofadr[0]) for j in range(arm.joints)]
    hooks = list(start(Physics(model, data, drive, step)))
    inner = round(arm.period / step)
    # control instants fall on t = 0, whatever the period
    before, after = round(HOLD / arm.period), int(np.ceil((duration + stretch) / arm.period))
    clock = np.arange(-before, after + 1) * arm.period
    goal, speed = motion(clock)
    data.qpos[drive], data.qvel[drive] = goal[0], speed[0]
    q, dq, motor = _steps(mujoco.mj_step, model, data, arm, drive, hooks, clock, goal, speed, inner, step)
    t = clock[0] + step * np.arange(len(q))
    if not np.isfinite(q).all() or abs(q[::inner] - goal).max() > 1.0:
        raise FloatingPointError("the simulated arm does not follow its reference")
    keep = t > -stretch - step / 2
    return Run(t[keep], q[keep], dq[keep], motor[keep], step, np.repeat(goal, inner, axis=0)[keep])


def _steps(
    advance: Callable[[Any, Any], None],
    model: Any,
    data: Any,
    arm: Arm,
    drive: list[int],
    hooks: list[Hook],
    clock: Array,
    goal: Array,
    speed: Array,
    inner: int,
    step: float,
) -> tuple[Array, Array, Array]:
    count = len(clock) * inner
    joints = range(arm.joints)
    Q, V, U = (np.empty((count, arm.joints)) for _ in range(3))
    qpos, qvel, force, losses = data.qpos, data.qvel, data.qfrc_applied, model.dof_frictionloss
    whole = drive == list(range(model.nv))
    friction = [link.friction for link in arm.links]
    goals, speeds, times = goal.tolist(), speed.tolist(), clock.tolist()
    row = 0
    for k, begin in enumerate(times):
        for i in range(inner):
            here = qpos if whole else qpos[drive]
            rate = qvel if whole else qvel[drive]
            Q[row], V[row] = here, rate
            if hooks or i == 0:
                q, v = here.tolist(), rate.tolist()
            if i == 0:  # zero-order hold
                u = [arm.kp[j] * (goals[k][j] - q[j]) + arm.kd[j] * (speeds[k][j] - v[j]) for j in joints]
                if arm.limit:
                    u = [min(max(x, -most), most) for x, most in zip(u, arm.limit, strict=True)]
                total = u
            if hooks:
                push, loss = [0.0] * arm.joints, friction.copy()
                for hook in hooks:
                    hook(begin + i * step, q, v, u, push, loss)
                total = [a + b for a, b in zip(u, push, strict=True)]
                for j in joints:
                    losses[drive[j]] = max(loss[j], _NEVER_ZERO)
            for j in joints:
                force[drive[j]] = total[j]
            U[row] = u
            advance(model, data)
            row += 1
    return Q, V, U


@dataclass(frozen=True)
class Sensors:
    """How a run becomes a log: rate (Hz), counts (rad), torque noise (N.m), AR(1) coefficient, `mean` or `command`.

    `mean` averages the torque over one sampling interval centred on the sample; `command` is what the controller
    set at that instant and will hold for one period, so it leads the motion by half a period, as in real drives.
    """

    rate: float
    encoder: tuple[float, ...]
    noise: tuple[float, ...]
    colour: float = 0.0
    torque: str = "mean"
    dither: float = 0.0  # counts, sd of what shakes the encoder; without it, repeated motions repeat its rounding too


@dataclass(frozen=True)
class Log:
    """t (N,), measured q and tau (N, J), and the torque before noise."""

    t: Array
    q: Array
    tau: Array
    clean: Array


def instants(outcome: Run, rate: float, duration: float) -> Array:
    """Rows of a run at which a log is sampled."""
    first = int(np.flatnonzero(np.abs(outcome.t) < outcome.step / 2)[0])
    stride = round(1 / (rate * outcome.step))
    return first + stride * np.arange(round(duration * rate) + 1)


def averaged(x: Array, rows: Array, width: int) -> Array:
    """Trapezoidal means of x (K, ...) over `width` (even) steps, centred on the given rows.

    A semi-implicit step is a leapfrog: the second difference of the positions about t[k] is the acceleration by the
    forces of row k, so row k belongs to t[k] itself, not to the interval after it. A mean over `width` rows alone would
    put the torque half a step late, which a good identification sees (0.25 ms).
    """
    total = np.concatenate([np.zeros_like(x[:1]), np.cumsum(x, axis=0)])
    low = rows - width // 2
    whole = total[low + width] - total[low]
    return (whole + (x[low + width] - x[low]) / 2) / width


def coloured(rng: np.random.Generator, count: int, sd: Array, colour: float) -> Array:
    """White (colour 0) or AR(1) noise (N, J) of standard deviations sd (J,)."""
    from scipy.signal import lfilter

    white = rng.standard_normal((count + 200, len(sd)))
    out = lfilter([np.sqrt(1 - colour**2)], [1, -colour], white, axis=0)[200:]
    return out * sd


def record(
    outcome: Run, sensors: Sensors, duration: float, rng: np.random.Generator, reported: Array | None = None
) -> Log:
    """The log of a run; `reported` (K, J) is the torque that the drive claims, where that is not what acted."""
    torque = outcome.motor if reported is None else reported
    rows = instants(outcome, sensors.rate, duration)
    width = round(1 / (sensors.rate * outcome.step))
    clean = averaged(torque, rows, width) if sensors.torque == "mean" else torque[rows]
    counts = np.array(sensors.encoder)
    shaken = outcome.q[rows] / counts + sensors.dither * rng.standard_normal((len(rows), len(counts)))
    q = np.round(shaken) * counts
    noise = coloured(rng, len(rows), np.array(sensors.noise), sensors.colour)
    return Log(np.arange(len(rows)) / sensors.rate, q, clean + noise, clean)
