"""Effects that other packages bring: entry points of the group `chebid.effects`, each an `Effect` class.

They are loaded when an effect is asked for that the library does not have, or all are wanted (`diagnose`). A package
that fails says so once, as a notice; it stops nothing unless its effect was asked for by name.
"""

import functools
import inspect
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points

from chebid.effects.effect import ArmEffect, Effect, JointEffect
from chebid.errors import Notice, Place

GROUP = "chebid.effects"
_KINDS = ("friction", "position", "transmission", "channel", "load", "time", "user")


@dataclass(frozen=True)
class Plugins:
    """What was found: the effects by name, and a notice for each that cannot be used, by its name."""

    effects: dict[str, type[Effect]]
    broken: dict[str, Notice]


@functools.cache
def load_plugins(taken: frozenset[str]) -> Plugins:
    """Load every entry point; names in `taken` stay with the library."""
    effects: dict[str, type[Effect]] = {}
    broken: dict[str, Notice] = {}
    for point in sorted(entry_points(group=GROUP), key=lambda point: (point.name, point.value)):
        try:
            kind = point.load()
            _check(kind, taken | set(effects))
        except (Exception, SystemExit) as err:  # a stranger's code: anything may happen
            broken[point.name] = _notice(point, err)
        else:
            effects[kind.name] = kind
    return Plugins(effects, broken)


def _notice(point: EntryPoint, err: BaseException) -> Notice:
    first = (str(err).splitlines() or [""])[0][:200]
    package = point.dist.name if point.dist else "an unknown package"
    text = f"the effect {point.name!r} of {package} ({point.value}) cannot be used: {type(err).__name__}: {first}"
    return Notice("plugin", text, Place())


def _check(kind: object, taken: frozenset[str] | set[str]) -> None:
    """Raise TypeError or ValueError when something is not an effect that can be used."""
    if not (isinstance(kind, type) and issubclass(kind, Effect)):
        raise TypeError("is not a subclass of chebid.effects.Effect")
    if inspect.isabstract(kind) or not issubclass(kind, JointEffect | ArmEffect):
        raise TypeError("is neither a JointEffect nor an ArmEffect")
    if not kind.name or not kind.sentence:
        raise ValueError("has no name or no sentence")
    if kind.name in taken:
        raise ValueError(f"its name {kind.name!r} is taken")
    if kind.kind not in _KINDS:
        raise ValueError(f"its kind {kind.kind!r} is none of {', '.join(_KINDS)}")
    inherited = (Effect.block, JointEffect.block)
    if kind.block in inherited and getattr(kind, "columns", None) in (None, JointEffect.columns):
        raise TypeError("defines neither columns nor block")
