"""A model as one regressor: rigid robot plus effects, parameters in the paper's order (eq. 19: joint by joint).

Effects that are made of the model's own torque (load friction, a torque's delay or gain, elastic joints) need it
before they have columns. `torque` gets it by itself, in two passes. `regressor` takes it from the motion
(`Motion.tau`), else from the parameters that the dynamics were last fitted with (`at`); to fit such a model, fit
`base` first, then `at` its result, and once more at the result of that.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from chebid.effects import Derived, Effect, Motion, make_effects, saturated
from chebid.effects.dependence import dependent_columns
from chebid.effects.trial import trial_motion, trial_values
from chebid.errors import InputError, Notice, Place, UsageError
from chebid.model import Model
from chebid.robots import Array, Parameter, Robot, make_robot

_CHUNK = 32768  # samples whose regressor is held at a time


@dataclass(frozen=True)
class Dynamics:
    """torque = regressor(motion) @ theta, theta in the order of `parameters`.

    `reference`: parameters by name, at which the model's own torque is taken where a motion does not give it.
    `dropped`: names of parameters left out because others say the same; `notices` tell which.
    """

    robot: Robot
    effects: tuple[Effect, ...]
    reference: Mapping[str, float] | None = field(default=None, compare=False)
    dropped: frozenset[str] = frozenset()
    notices: tuple[Notice, ...] = ()

    @property
    def joints(self) -> tuple[str, ...]:
        return self.robot.joints

    # names and places -----------------------------------------------------------------------------------------------

    @cached_property
    def bound(self) -> tuple[Effect, ...]:
        """The effects, knowing the robot."""
        return tuple(effect.bind(self.robot) for effect in self.effects)

    @cached_property
    def _groups(self) -> tuple[tuple[Parameter, ...], ...]:
        """Parameters of the robot, then of each effect, with different names."""
        own = [effect.parameters(self.joints, self.robot.rotary) for effect in self.bound]
        return _different((self.robot.parameters, *own))

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """By joint, those of the whole arm last; within a joint the rigid body first, then effects in file order."""
        place = {joint: i for i, joint in enumerate(self.joints)}
        kept = [p for group in self._groups for p in group if p.name not in self.dropped]
        return tuple(sorted(kept, key=lambda p: place.get(p.joint or "", len(place))))

    @cached_property
    def _index(self) -> dict[str, int]:
        return {p.name: i for i, p in enumerate(self.parameters)}

    @cached_property
    def _places(self) -> tuple[tuple[NDArray[np.int64], NDArray[np.int64]], ...]:
        """Of each group: which of its columns are kept, and where they go."""
        out = []
        for group in self._groups:
            kept = [i for i, p in enumerate(group) if p.name in self._index]
            out.append((np.array(kept, dtype=int), np.array([self._index[group[i].name] for i in kept], dtype=int)))
        return tuple(out)

    # torque ---------------------------------------------------------------------------------------------------------

    def regressor(self, motion: Motion) -> Array:
        """(N, J, P) at the instants of the motion. Raises UsageError when the model's own torque is needed and not
        known.
        """
        motion = self._completed(motion)
        out = np.zeros((*motion.q.shape, len(self.parameters)))
        kept, at = self._places[0]
        out[:, :, at] = self.robot.regressor(motion.q, motion.dq, motion.ddq)[:, :, kept]
        for effect, (kept, at) in zip(self.bound, self._places[1:], strict=True):
            if len(kept):
                rows = np.array(effect.rows(len(self.joints)))
                out[:, rows[:, None], at] = _evaluate(effect, motion)[:, :, kept]
        return out

    def block(self, effect: Effect, motion: Motion) -> Array:
        """(N, J, k): torques per parameter of any effect, in this model or not."""
        bound = effect.bind(self.robot)
        motion = self._completed(motion) if bound.needs_model else motion
        part = _evaluate(bound, motion)
        out = np.zeros((*motion.q.shape, part.shape[2]))
        out[:, list(bound.rows(len(self.joints)))] = part
        return out

    def torque(self, motion: Motion, theta: Array) -> Array:
        """Inverse dynamic model (eq. 16) at N instants: (N, J). The model's own torque is that of theta."""
        motion = self.prepare(motion, theta) if self.needs_model else motion
        out = np.empty(motion.q.shape)
        for piece in _pieces(len(motion)):
            out[piece] = self.regressor(motion.cut(piece)) @ theta
        return out

    # the model's own torque -----------------------------------------------------------------------------------------

    @property
    def needs_model(self) -> bool:
        """Whether an effect is made of the model's own torque."""
        return any(effect.needs_model for effect in self.bound)

    @cached_property
    def base(self) -> "Dynamics":
        """The model without the effects that are made of its torque."""
        kept = tuple(effect for effect in self.effects if not effect.bind(self.robot).needs_model)
        return replace(self, effects=kept, reference=None)

    def at(self, theta: Array | Mapping[str, float]) -> "Dynamics":
        """The same model, its own torque taken at theta (P,), or at values by name (those of `base`, for instance)."""
        return replace(self, reference=theta if isinstance(theta, Mapping) else self.named(theta))

    def named(self, theta: Array) -> dict[str, float]:
        """theta (P,) by name."""
        return {p.name: float(value) for p, value in zip(self.parameters, theta, strict=True)}

    def prepare(self, motion: Motion, theta: Array | Mapping[str, float]) -> Motion:
        """The motion with what effects need to know of the model: its torque without them, its rigid parameters."""
        values = theta if isinstance(theta, Mapping) else self.named(theta)
        whole = motion.whole or motion
        key = (id(self.robot), self.base.effects, tuple(sorted(values.items())))
        filled, _ = whole.remember(key, lambda: (self._filled(whole, values), self.robot))
        return filled.cut(motion.piece) if motion.whole is not None else filled

    def _filled(self, motion: Motion, values: Mapping[str, float]) -> Motion:
        base = self.base
        tau = base.torque(motion, np.array([values.get(p.name, 0.0) for p in base.parameters]))
        return motion.with_model(tau, np.array([values.get(p.name, 0.0) for p in self.robot.parameters]))

    def _completed(self, motion: Motion) -> Motion:
        known = motion.tau is not None and (motion.rigid is not None or self.reference is None)
        if known or self.reference is None:
            lacking = [effect.name for effect in self.bound if effect.needs_model] if not known else []
            if lacking:
                raise UsageError(
                    f"{', '.join(lacking)}: made of the model's own torque, which is not known yet",
                    hint="identify the model without it first, then add it (chebid add)",
                )
            return motion
        return self.prepare(motion, self.reference)

    # what the parts mean --------------------------------------------------------------------------------------------

    def rigid(self, theta: Array) -> Array:
        """Values of the robot's own parameters, in its order."""
        return np.array([theta[self._index[p.name]] for p in self.robot.parameters])

    def terms(self, theta: Array) -> list[tuple[Effect, Array]]:
        """Each effect with the values (k,) of its parameters; zero for those that were left out."""
        values = self.named(theta)
        return [
            (effect, np.array([values.get(p.name, 0.0) for p in group]))
            for effect, group in zip(self.bound, self._groups[1:], strict=True)
        ]

    def names(self, effect: Effect) -> tuple[str, ...]:
        """Names of the parameters of one of the effects."""
        group = self._groups[1 + self.effects.index(effect)]
        return tuple(p.name for p in group if p.name in self._index)

    def derived(self, theta: Array) -> tuple[Derived, ...]:
        """What the parameters mean beyond themselves: rest positions, stiffnesses, tilts."""
        terms = self.terms(theta)
        return tuple(d for effect, values in terms for d in effect.derived(values.tolist(), self.robot.rotary))

    def elsewhere(self, theta: Array) -> Array:
        """theta (P,) for another log: without what happened once, in the log of the fit."""
        gone = {name for effect in self.effects if effect.once for name in self.names(effect)}
        return np.array([0.0 if p.name in gone else value for p, value in zip(self.parameters, theta, strict=True)])

    def hyperparameters(self) -> dict[str, dict[str, object]]:
        """Hyper-parameters of the effects that have them, by `effect:joint`, for the `fit:` section."""
        out: dict[str, dict[str, object]] = {}
        for effect in self.effects:
            if effect.hypers():
                label = effect.name if effect.joint is None else f"{effect.name}:{self.joints[effect.joint]}"
                same = sum(1 for key in out if key.split(".")[0] == label)
                kinds = effect.hypers()
                out[f"{label}.{same + 1}" if same else label] = {
                    name: self.joints[value] if kinds[name].unit == "joint" else value
                    for name, value in effect.hyper.items()
                    if value is not None
                }
        return out

    def signs(self, row: int) -> tuple[int, ...]:
        """Joints whose direction of motion matters for the torque of joint number `row`."""
        count = len(self.joints)
        found = {joint for effect in self.effects if row in effect.rows(count) for joint in effect.signs}
        return tuple(sorted(found))

    def unusable(self, motion: Motion, measured: Array) -> NDArray[np.bool_]:
        """(N, J): samples of the measured torque (N, J) that effects say to leave out, because the drive clips."""
        return saturated(self.effects, motion, measured)

    # what depends on what -------------------------------------------------------------------------------------------

    def dependent(self) -> dict[str, list[str]]:
        """Parameters of effects that no motion can tell from others before them, each with those others."""
        trial = trial_motion(len(self.joints))
        trial = self.prepare(trial, trial_values(len(self.parameters))) if self.needs_model else trial
        late = [False, *(effect.needs_model for effect in self.bound)]  # made of the others: they are what is too much
        groups = [group for _, group in sorted(zip(late, self._groups, strict=True), key=lambda pair: pair[0])]
        names = [p.name for group in groups for p in group if p.name in self._index]
        columns = self.regressor(trial)[:, :, [self._index[name] for name in names]]
        rigid = sum(1 for p in self._groups[0] if p.name in self._index)
        found = dependent_columns(columns.reshape(-1, len(names)), rigid)
        return {names[i]: [names[k] for k in made_of] for i, made_of in found.items()}


def make_dynamics(model: Model) -> Dynamics:
    """The dynamics of a model file; those of a fitted model know their own torque.

    Where a parameter says nothing that others do not say (the rotor of a SCARA's first joint), it is left out with a
    notice; an effect asked for on one joint, or on the whole arm, that says nothing at all is an InputError. A model
    that holds values for such parameters keeps them: they cannot be identified, but they can act.
    """
    robot, effects = make_robot(model), make_effects(model)
    values = None if model.fit is None else {name: p.value for name, p in model.fit.parameters.items()}
    dynamics = Dynamics(robot, effects, values)
    if model.robot.type == "axes" and model.robot.types is None and values is None:
        dynamics = replace(dynamics, notices=(_revolute(model),))
    found = {name: others for name, others in dynamics.dependent().items() if name not in (values or {})}
    if not found:
        return dynamics
    if values is None:
        _refuse_idle(dynamics, found, model)
    notices = tuple(_left_out(name, others, model) for name, others in found.items()) if values is None else ()
    left = tuple(effect for effect in effects if not _idle(dynamics, effect, found))
    return replace(dynamics, effects=left, dropped=frozenset(found), notices=dynamics.notices + notices)


def _revolute(model: Model) -> Notice:
    text = "has no types: all joints are taken as revolute (rad, N.m); write 'types: [prismatic]' for one that slides"
    return Notice("types", text, Place(file=str(model.path), key="robot"))


def _idle(dynamics: Dynamics, effect: Effect, found: Mapping[str, list[str]]) -> bool:
    """Whether an effect has parameters, and none of its own."""
    names = dynamics.names(effect)
    return bool(names) and all(name in found for name in names)


def settle(dynamics: Dynamics, fit: Callable[[Dynamics], Array], rounds: int = 20, tolerance: float = 1e-9) -> Dynamics:
    """The dynamics with their own torque taken at their own fit, which they and `fit` find in turns.

    `fit` gives theta (P,) for dynamics whose columns are known. It is called once for the effects that need no torque
    of the model, then until no parameter moves by more than `tolerance` of the largest; what has not settled
    after `rounds` is left where it is. Dynamics without such effects come back unfitted.
    """
    if not dynamics.needs_model:
        return dynamics
    current = dynamics.at(dynamics.base.named(fit(dynamics.base)))
    for _ in range(rounds):
        before, current = current.reference or {}, dynamics.at(fit(current))
        if _unmoved(before, current.reference or {}, tolerance):
            break
    return current


def _unmoved(before: Mapping[str, float], after: Mapping[str, float], tolerance: float) -> bool:
    apart = max(abs(value - before.get(name, 0.0)) for name, value in after.items())
    return apart <= tolerance * max(map(abs, after.values()))


def _refuse_idle(dynamics: Dynamics, found: Mapping[str, list[str]], model: Model) -> None:
    """Raise InputError for an entry that names its joint and has no parameter of its own."""
    asked = {(spec.effect, spec.joint): number for number, spec in enumerate(model.effects)}
    for effect in dynamics.effects:
        joint = None if effect.joint is None else model.joints[effect.joint]
        if (effect.name, joint) in asked and _idle(dynamics, effect, found):
            others = sorted({other for name in dynamics.names(effect) for other in found[name]})
            raise InputError(
                f"cannot be told from {_listed(others)} on any motion",
                hint="remove this entry: what it would say is in those parameters already",
                place=Place(str(model.path), key=f"effects.{asked[effect.name, joint]}", value=effect.name),
            )


def _left_out(name: str, others: list[str], model: Model) -> Notice:
    text = f"{name} is left out: no motion can tell it from {_listed(others)}, which contains it"
    return Notice("dependent", text, Place(file=str(model.path)))


def _listed(names: list[str], most: int = 6) -> str:
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def _different(groups: tuple[tuple[Parameter, ...], ...]) -> tuple[tuple[Parameter, ...], ...]:
    """The same with a number behind a name that was there before: two ripples on one joint are bc1 and bc1.2."""
    seen: dict[str, int] = {}
    out = []
    for group in groups:
        named = []
        for p in group:
            seen[p.name] = seen.get(p.name, 0) + 1
            named.append(p if seen[p.name] == 1 else replace(p, name=f"{p.name}.{seen[p.name]}"))
        out.append(tuple(named))
    return tuple(out)


def _evaluate(effect: Effect, motion: Motion) -> Array:
    """(N, R, k) of an effect; what another package does wrong is its error, with its name."""
    if type(effect).__module__.partition(".")[0] == "chebid":
        return effect.on(motion)
    place = Place(key="effects", value=effect.name)
    hint = f"this effect comes from {type(effect).__module__}: ask its authors, or leave it out"
    try:
        out = np.asarray(effect.on(motion), dtype=float)
    except Exception as err:
        raise InputError(f"failed: {type(err).__name__}: {err}", hint=hint, place=place) from err
    wanted = (len(motion), len(effect.rows(motion.q.shape[1])), len(effect.symbols))
    if out.shape != wanted:
        raise InputError(f"gives columns of shape {out.shape} instead of {wanted}", hint=hint, place=place)
    if not np.isfinite(out).all():
        raise InputError("gives columns that are not finite", hint=hint, place=place)
    return out


def _pieces(count: int) -> Iterator[slice]:
    for start in range(0, count, _CHUNK):
        yield slice(start, min(start + _CHUNK, count))
