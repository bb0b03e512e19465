"""All that a search for a separating motion is given: rivals, logs of the fit, noise, gate, ranges of settings."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from chebid.dynamics import Dynamics, make_dynamics
from chebid.effects import Effect, Motion
from chebid.errors import NoAnswerError, Place
from chebid.excite.limits import Limits
from chebid.excite.rivals import Rival
from chebid.excite.search import Family
from chebid.excite.size import FittedOn, Noise, find_logs, find_noise
from chebid.model import Model, per_joint
from chebid.robots import Array

_MOST, _MOST_PAST = 600, 2000  # samples of the search; where effects remember the past, their torque depends on them
_TRIALS = 5  # random motions that tell what can be told apart at all
_SLOW = 0.01  # of the largest velocity: the slowest speed that counts, unless the model's fit says more
_FAR, _FAST = 0.9, 0.7  # of the limits on position and velocity: for the grids of hyper-parameters


@dataclass(frozen=True)
class Task:
    """`t` (N,) s of the record, `searched` those of the search; `gate` (J,) rad/s or m/s, slowest speeds that count.

    `trials`: random motions that tell what can be told apart at all; `pictured`: a motion all over the limits, for the
    ranges of hyper-parameters; `fitted`: the logs of the model's fit, if they are at hand.
    """

    model: Model
    rivals: tuple[Rival, ...]
    family: Family
    t: Array
    searched: Array
    fitted: FittedOn | None
    dynamics: Dynamics
    gate: Array
    noise: Noise
    trials: tuple[Motion, ...]
    pictured: Motion

    def settings(self, rival: Rival) -> tuple[Effect, ...]:
        """Settings worth trying. Raises NoAnswerError where there are none."""
        return _settings(rival, self.pictured, self.gate_of(rival.joint))

    def gate_of(self, joint: int | None) -> float:
        return float(self.gate[joint or 0])

    @property
    def place(self) -> Place:
        return Place(file=str(self.model.path))


def make_task(
    model: Model,
    rivals: tuple[Rival, ...],
    logs: Sequence[Path],
    family: Family,
    t: Array,
    random: np.random.Generator,
) -> Task:
    """The task for a record at t (N,) s. Raises NoAnswerError for a rival that says nothing beside the model."""
    paths = list(logs) or find_logs(model)
    fitted = FittedOn(model, paths) if paths else None
    dynamics = _dynamics(model, fitted)
    pictured = _pictured(dynamics, family.limits, t)
    _refuse_idle(dynamics, rivals, pictured, model)
    past = any(e.memory for e in dynamics.effects) or any(rival.kind.memory for rival in rivals)
    searched = t[:: -(-len(t) // (_MOST_PAST if past else _MOST))]
    trials = [Motion(searched, *family.motion(family.random(random), searched)) for _ in range(_TRIALS)]
    noise = find_noise(model, dynamics, trials, fitted)
    gate = _gate(model, fitted, family.limits)
    return Task(model, rivals, family, t, searched, fitted, dynamics, gate, noise, tuple(trials), pictured)


def _dynamics(model: Model, fitted: FittedOn | None) -> Dynamics:
    """The model's dynamics, knowing its own torque where it can be known."""
    made = make_dynamics(model)
    return made if made.reference is not None or fitted is None else fitted.problem.dynamics.at(fitted.theta)


def _gate(model: Model, fitted: FittedOn | None, limits: Limits) -> Array:
    if model.processing.velocity_gate is not None:
        return np.array(per_joint(model.processing.velocity_gate, len(model.joints)))
    least = _SLOW * limits.velocity
    if fitted is not None:
        return np.maximum(fitted.problem.gate, least)
    recorded = model.fit.record.velocity_gate if model.fit else None
    return np.maximum([recorded[joint] for joint in model.joints], least) if recorded else least


def _pictured(dynamics: Dynamics, limits: Limits, t: Array) -> Motion:
    """A motion all over the limits; its velocity is not the rate of its position."""
    wave = np.sin(np.linspace(0.0, 40 * np.pi, len(t)))[:, None]
    motion = Motion(t, _FAR * limits.position * wave, _FAST * limits.velocity * wave, limits.acceleration * wave)
    if dynamics.reference is not None:
        return dynamics.prepare(motion, dynamics.reference)
    return motion.with_model(np.ones_like(motion.q), np.zeros(len(dynamics.robot.parameters)))


def _settings(rival: Rival, motion: Motion, gate: float) -> tuple[Effect, ...]:
    found = tuple(rival.settings(motion, gate))
    if not found:
        raise NoAnswerError(f"{rival.label} does not show in motions", hint="leave it out of the rivals")
    return found


def _refuse_idle(dynamics: Dynamics, rivals: Sequence[Rival], pictured: Motion, model: Model) -> None:
    for rival in rivals:
        effect = _settings(rival, pictured, 0.01)[0].bind(dynamics.robot)
        if effect.needs_model and dynamics.reference is None:
            raise NoAnswerError(
                f"{rival.label} is made of the model's own torque, which is not known yet",
                hint="identify the model first, and give the fitted model",
                place=Place(file=str(model.path)),
            )
        more = replace(dynamics, effects=(*dynamics.effects, effect))
        found, names = more.dependent(), more.names(effect)
        if names and all(name in found for name in names):
            others = ", ".join(dict.fromkeys(other for name in names for other in found[name]))
            raise NoAnswerError(
                f"{rival.label}: no motion tells it from {others} of the model, which say the same",
                hint="leave it out of the rivals: adding it would change no prediction",
                place=Place(file=str(model.path)),
            )
