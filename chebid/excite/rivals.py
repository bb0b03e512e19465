"""Rival effects: which of several it is that the model lacks, as named on the command line."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from chebid.effects import Effect, Motion, all_effects
from chebid.errors import NoAnswerError, UsageError
from chebid.model import Model

_ONCE = "external_push"
_MOST_SETTINGS = 60  # of one rival: of a longer grid, every second, third, ...


@dataclass(frozen=True)
class Rival:
    """One of the effects that might be missing. `joint` counts from 0, None for the whole arm."""

    kind: type[Effect]
    joint: int | None
    label: str

    def settings(self, motion: Motion, gate: float) -> list[Effect]:
        """With each setting worth trying on a motion like this one; `gate`: slowest speed used on the joint."""
        fixed: dict[str, Any] = {"t0": None} if self.kind.name == "payload" else {}  # on a new record: from the start
        found = [effect for effect in self.kind.candidates(motion, self.joint, gate) if fixed.items() <= _own(effect)]
        return found[:: -(-len(found) // _MOST_SETTINGS)] if found else []


def _own(effect: Effect) -> Any:
    return effect.hyper.items()


def read_rivals(names: Sequence[str], model: Model) -> tuple[Rival, ...]:
    """Rivals from `name` or `name:joint`. Raises UsageError for what does not exist or stands in the model already,
    NoAnswerError for an effect that no motion brings back.
    """
    if len(dict.fromkeys(names)) < 2:
        hint = "such as --separate stribeck:q2 viscous_power:q2"
        raise UsageError("rivals are two different effects at least", hint=hint)
    rivals = [_rival(name, model) for name in dict.fromkeys(names)]
    seen: dict[tuple[str, int | None], str] = {}
    for rival in rivals:
        other = seen.setdefault((rival.kind.name, rival.joint), rival.label)
        if other is not rival.label:
            raise UsageError(f"{rival.label} is named twice", hint="name each rival once")
    return tuple(rivals)


def _rival(name: str, model: Model) -> Rival:
    word, _, joint = name.partition(":")
    kinds, _ = all_effects()
    if word not in kinds:
        raise UsageError(f"unknown effect {word!r}", hint=f"choose one of: {', '.join(sorted(kinds))}")
    kind = kinds[word]
    at = _joint(kind, joint, model)
    label = word if at is None else f"{word}:{model.joints[at]}"
    if any(spec.effect == word and (at is None or spec.joint in (None, model.joints[at])) for spec in model.effects):
        hint = "name effects that the model lacks; a copy of the model file without it can be asked"
        raise UsageError(f"the model has {label} already", hint=hint)
    if word == _ONCE:
        raise NoAnswerError(
            f"{label}: a push happens once, and no motion brings it back",
            hint="record another log: what is not in it was a push",
        )
    if word == "saturation":
        raise NoAnswerError(
            f"{label}: a limit of the drive shows in the torque and not in the motion",
            hint="look for torque that stays at one value, and leave these samples out",
        )
    return Rival(kind, at, label)


def _joint(kind: type[Effect], joint: str, model: Model) -> int | None:
    """The joint that is meant. Raises UsageError."""
    if kind.whole_arm:
        if joint:
            raise UsageError(f"{kind.name} concerns the whole arm, not one joint", hint=f"write {kind.name}")
        return None
    if not joint and len(model.joints) > 1:
        listed = ", ".join(f"{kind.name}:{name}" for name in model.joints)
        raise UsageError(f"{kind.name} on which joint?", hint=f"write one of: {listed}")
    if joint and joint not in model.joints:
        raise UsageError(f"there is no joint {joint!r}", hint=f"choose one of: {', '.join(model.joints)}")
    return model.joints.index(joint) if joint else 0
