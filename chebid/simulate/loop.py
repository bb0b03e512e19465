"""`simulate`: a model under joint PD control along a reference, as its log would be."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from chebid.dynamics import Dynamics, make_dynamics
from chebid.errors import InputError, NoAnswerError, Notice, Place, UsageError
from chebid.model import Model, per_joint
from chebid.model.schema import ControlSection, SensorsSection
from chebid.robots import Array
from chebid.simulate.noise import averaged, encoder, held, torque_noise
from chebid.simulate.reference import Reference
from chebid.simulate.transmission import transmission

TORQUE_LOGS = ("average", "command")
NOISES = ("white", "coloured", "none")
_LARGEST_STEP = 2e-3  # s
_TOLERANCE = 1e-12  # of positions, per step: halving the steps changes 20 s of motion by less than 1e-9


@dataclass(frozen=True)
class Simulated:
    """A simulated log of N samples at t (N,) s: `q` (N, J) encoders, `tau` (N, J) torque with noise, `reference`.

    And what no log holds: `q_true`, `dq`, `ddq` (N, J), `link` (N, J) positions of the links, which are others than
    those of the motors in joints with a spring or a gap, `torque` (N, J) applied from each instant on, `sticks` (N, J)
    joints held by dry friction. `clock` (K,) s and `drive` (K, J): control instants and the torques held after them.
    `notices`: what was assumed.
    """

    t: Array
    q: Array
    tau: Array
    reference: Array
    q_true: Array
    dq: Array
    ddq: Array
    link: Array
    torque: Array
    sticks: Array
    clock: Array
    drive: Array
    notices: tuple[Notice, ...] = ()

    @property
    def largest_error(self) -> Array:
        """(J,): how far the arm was from the reference."""
        return np.abs(self.reference - self.q_true).max(axis=0)


@dataclass(frozen=True)
class Options:
    """How the simulation is run and logged.

    `rate` Hz of the log (default: that of the reference); `duration` s (default: that of the reference; the last
    position is held after it); `torque_log`: `average` over one log interval centred on the sample, or `command`, the
    torque commanded last, which leads by half a control period; `noise`: `white`, `coloured` (correlation time
    `noise.CORRELATION_TIME`) or `none`. `step` (s) and `tolerance` of the integration; `generic`: use the regressor.
    """

    rate: float | None = None
    duration: float | None = None
    torque_log: str = "average"
    noise: str = "white"
    step: float = _LARGEST_STEP
    tolerance: float = _TOLERANCE
    generic: bool = False


def simulate(
    model: Model, theta: Array, reference: Reference, *, seed: int = 0, options: Options | None = None
) -> Simulated:
    """Simulate one log of the model with parameters theta (P,).

    The drive runs at the control's rate: torque = kp (r - q) + kd (dr - dq), held for a period; q is what the encoder
    shows, dq its difference to one period before, as in a real drive. The seed draws the torque noise and where,
    within a count, each encoder has its zero. Control law and sensors are those of the model file.

    Raises InputError when the model has no control or sensors section, or a spring or gap on a motor without inertia;
    NoAnswerError when its motion breaks down.
    """
    return simulate_batch(model, theta, reference, [seed], options=options)[0]


def simulate_batch(
    model: Model, theta: Array, reference: Reference, seeds: Sequence[int], *, options: Options | None = None
) -> list[Simulated]:
    """One log per seed: Monte-Carlo."""
    options = options or Options()
    _check(options)
    return _Loop(model, theta, reference, options).logs(seeds)


class _Loop:
    """What is the same for every seed, and the run for one."""

    def __init__(self, model: Model, theta: Array, reference: Reference, options: Options) -> None:
        control, sensors = _control(model), _sensors(model)
        self.dynamics, self.theta = make_dynamics(model), np.asarray(theta, dtype=np.float64)
        self.options, self.place = options, Place(str(model.path), key="fit")
        count = len(self.dynamics.joints)
        laws = (control.kp, control.kd, sensors.encoder, 0.0)
        self.law = np.array([*(per_joint(v, count) for v in laws), _clipping(self.dynamics)])
        self.delay = sum(float(p[0]) for effect, p in self.dynamics.terms(self.theta) if effect.name == "torque_delay")
        self.noise = np.array(per_joint(sensors.torque_noise, count))
        rate = options.rate or min(reference.rate, control.rate)
        self.at = _instants(options.duration or reference.duration, rate)
        self.clock = _instants(float(self.at[-1]), control.rate)
        start = reference.at(np.zeros(1))[:, 0]
        self.hangs = transmission(model, self.dynamics, self.theta, reference.q)
        self.start = self.hangs.start(self.dynamics, self.theta, start)
        self.reference = np.ascontiguousarray(self.hangs.widened(reference.at(self.clock), 0.0))
        self.logged = reference.at(self.at)[0]

    def logs(self, seeds: Sequence[int]) -> list[Simulated]:
        """One log per seed."""
        from chebid.simulate.compiled import compiled

        rigid, generic = self.dynamics.rigid(self.theta), self.options.generic
        with (
            compiled() as (kernel, plant),
            plant.compiled_effects(self.dynamics, self.theta) as effects,
            plant.compiled_plant(self.dynamics.robot, rigid, generic) as robot,
        ):
            return [self._log(kernel, (*robot, *effects), np.random.default_rng(seed)) for seed in seeds]

    def _log(self, kernel: Any, moving: tuple[Any, ...], random: np.random.Generator) -> Simulated:
        """The log of one run; `moving`: plant and effects."""
        count, hangs = len(self.noise), self.hangs
        law = hangs.widened(self.law, 0.0)  # nothing drives a link but its motor
        law[3, :count] = random.uniform(-0.5, 0.5, count)
        drive, out = np.zeros((len(self.clock), hangs.masses)), np.zeros((4, len(self.at), hangs.masses))
        settings = np.array([self.options.step, self.options.tolerance, self.options.step, 0.0, 0.0, 0.0])
        mode = np.concatenate([moving[-1], np.full(hangs.masses - count, kernel.FREE)])
        system = (*moving[:-1], mode)
        loop = (self.start, law, self.reference, self.clock, self.at, drive, out, settings)
        status, k = kernel.run(*system, *loop, *kernel.workspace(hangs.link, hangs.hung))
        if status != kernel.OK:
            raise self._failure(kernel, status, k)
        step = float(self.at[1])
        logged = averaged if self.options.torque_log == "average" else held
        drive = drive[:, :count]
        tau = logged(self.clock, drive, self.at - self.delay, step) + torque_noise(
            random, self.options.noise, self.noise, len(self.at), step
        )
        link = out[0][:, hangs.link]
        q, dq, ddq, modes = out[:, :, :count]
        applied, sticks = held(self.clock, drive, self.at, step), modes == 0
        q_logged = encoder(q, law[2, :count], law[3, :count])
        return Simulated(
            self.at, q_logged, tau, self.logged, q, dq, ddq, link, applied, sticks, self.clock, drive, hangs.notices
        )

    def _failure(self, kernel: Any, status: int, k: int) -> NoAnswerError:
        """Why the motion broke down, and when."""
        reasons = {
            kernel.NOT_POSITIVE: (
                "the mass matrix is not positive definite: no real arm has these inertias",
                "identify again with a more exciting motion, or simulate a model of known inertias",
            ),
            kernel.NOT_FINITE: (
                "the motion grows beyond all bounds",
                "lower kp and kd, or raise the rate of the control: section; check the fitted values",
            ),
            kernel.TOO_MANY_EVENTS: ("a joint sticks and slips without end", "check the friction of the fit"),
            kernel.STEP_TOO_SMALL: (
                "the motion cannot be followed",
                "check the fitted values and hyper-parameters; a link rings beside a drive that is too slow for its "
                "spring: raise the rate of the control: section or lower kd",
            ),
            kernel.NO_FIXED_POINT: (
                "friction that grows with the load has no solution",
                "check load_friction and torque_gain: they must be well below 1",
            ),
        }
        message, hint = reasons[status]
        return NoAnswerError(f"{message} (at t = {self.clock[k]:.4g} s)", hint=hint, place=self.place)


def _clipping(dynamics: Dynamics) -> Array:
    """(J,): torque at which each drive clips."""
    out = np.full(len(dynamics.joints), np.inf)
    for effect in dynamics.effects:
        if effect.name == "saturation":
            out[list(effect.rows(len(out)))] = effect.hyper["limit"]
    return out


def _instants(duration: float, rate: float) -> Array:
    """(K,) s from 0 to the duration."""
    return np.arange(int(np.floor(duration * rate * (1 + 1e-9))) + 1) / rate


def _control(model: Model) -> ControlSection:
    """Raises InputError without a control section."""
    if model.control is None:
        raise InputError(
            "has no control law",
            hint="add it to the model file, such as 'control: {kp: [1400, 60], kd: [100, 2.6], rate: 500}'",
            place=Place(str(model.path), key="control"),
        )
    return model.control


def _sensors(model: Model) -> SensorsSection:
    """Raises InputError without a sensors section."""
    if model.sensors is None:
        raise InputError(
            "has no sensors",
            hint="add them to the model file, such as 'sensors: {encoder: 1.6e-4, torque_noise: [0.25, 0.025]}'; "
            "'sensors: {}' is perfect ones",
            place=Place(str(model.path), key="sensors"),
        )
    return model.sensors


def _check(options: Options) -> None:
    """Raises UsageError for options that mean nothing."""
    for name, value in (("rate", options.rate), ("duration", options.duration)):
        if value is not None and not 0 < value < 1e9:
            raise UsageError(f"{name} {value!r} is not positive", hint="give Hz or s, such as 100 or 20")
    for name, text, known in (("torque log", options.torque_log, TORQUE_LOGS), ("noise", options.noise, NOISES)):
        if text not in known:
            raise UsageError(f"{name} {text!r} is unknown", hint=f"choose one of: {', '.join(known)}")
