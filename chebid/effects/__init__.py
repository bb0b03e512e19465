"""The library of physical effects. Friction of the first model, a missing effect, a user's own: all are effects."""

from chebid.effects import friction
from chebid.effects.effect import Effect, Motion, Units
from chebid.errors import InputError, Place
from chebid.model import EffectSpec, Model

__all__ = ["LIBRARY", "Effect", "Motion", "Units", "make_effects"]

LIBRARY: dict[str, type[Effect]] = {effect.name: effect for effect in friction.EFFECTS}


def make_effects(model: Model) -> tuple[Effect, ...]:
    """The effects of a model file, joint by joint in file order. Raises InputError for unknown or repeated ones."""
    out: list[Effect] = []
    for number, spec in enumerate(model.effects):
        where = Place(str(model.path), key=f"effects.{number}", value=spec.effect)
        kind = _kind(spec, where)
        joints = model.joints if spec.joint is None else (spec.joint,)
        for joint in joints:
            effect = kind(model.joints.index(joint), **spec.settings)
            if effect in out:
                raise InputError(f"is on joint {joint!r} twice", hint="remove one of the two entries", place=where)
            out.append(effect)
    return tuple(out)


def _kind(spec: EffectSpec, where: Place) -> type[Effect]:
    kind = LIBRARY.get(spec.effect)
    if kind is None:
        raise InputError("is no effect of the library", hint=f"known are: {', '.join(sorted(LIBRARY))}", place=where)
    unknown = set(spec.settings) - set(kind.__dataclass_fields__)
    if unknown:
        raise InputError(f"has no setting {sorted(unknown)[0]!r}", hint="remove it or check its spelling", place=where)
    return kind
