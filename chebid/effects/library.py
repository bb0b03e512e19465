"""All effects by name, and the way from a model file's entries to effects and back."""

from collections.abc import Mapping
from typing import Any

from chebid.effects import channel, coupling, drift, friction, load, position, transmission
from chebid.effects.effect import Effect
from chebid.effects.hyper import Hyper
from chebid.effects.plugins import load_plugins
from chebid.effects.trial import trial_motion, trial_values
from chebid.effects.units import Units
from chebid.effects.user import formula_effect
from chebid.errors import InputError, Notice, Place
from chebid.model import EffectSpec, Model
from chebid.robots import Scara

_ROOMS = (friction, position, transmission, coupling, drift, channel, load)
LIBRARY: dict[str, type[Effect]] = {effect.name: effect for room in _ROOMS for effect in room.EFFECTS}


def all_effects() -> tuple[dict[str, type[Effect]], tuple[Notice, ...]]:
    """The library and the effects of other packages, with a notice for each that cannot be used."""
    plugins = load_plugins(frozenset(LIBRARY))
    return LIBRARY | plugins.effects, tuple(plugins.broken.values())


def make_effects(model: Model) -> tuple[Effect, ...]:
    """The effects of a model file, in file order.

    Raises InputError for effects that are unknown or stand there twice, and for hyper-parameters that are unknown,
    missing or out of range; it names the entry, the key and the value.
    """
    out: list[Effect] = []
    for number, spec in enumerate(model.effects):
        where = Place(str(model.path), key=f"effects.{number}", value=spec.effect)
        for effect in _from_entry(spec, model, where):
            if effect in out:
                at = "" if effect.joint is None else f"on joint {model.joints[effect.joint]!r} "
                raise InputError(f"is {at}twice", hint="remove one of the two entries", place=where)
            out.append(effect)
    return tuple(out)


def specify(effect: Effect, joints: tuple[str, ...]) -> EffectSpec:
    """The entry of a model file for an effect, its hyper-parameters included."""
    joint = None if effect.joint is None else joints[effect.joint]
    return EffectSpec.model_validate({"effect": effect.name, "joint": joint} | effect.settings(joints))


def _from_entry(spec: EffectSpec, model: Model, where: Place) -> list[Effect]:
    """One effect, or one per joint."""
    kind = effect_class(spec, len(model.joints), where)
    if kind.whole_arm:
        if spec.joint is not None:
            raise InputError("concerns the whole arm, not one joint", hint="remove joint: from this entry", place=where)
        return [kind(None, **_read(kind, spec, model, None, where))]
    out = []
    for joint in model.joints if spec.joint is None else (spec.joint,):
        settings = _read(kind, spec, model, joint, where)
        at = model.joints.index(joint)
        if settings.get("source", -1) == at and "source" in kind.hypers():
            if spec.joint is None:
                continue  # on every joint but the source itself
            raise _wrong(where, "source", "is the joint itself", "name another joint", joint)
        out.append(kind(at, **settings))
    return out


def effect_class(spec: EffectSpec, joints: int, where: Place) -> type[Effect]:
    """The class of an entry: of the library, of a formula, or of another package. Raises InputError."""
    if "formula" in spec.settings:
        if spec.effect in LIBRARY:
            raise InputError("is an effect of the library", hint="give your formula another name", place=where)
        return formula_effect(spec.effect, spec.settings, joints, where)
    if spec.effect in LIBRARY:
        return LIBRARY[spec.effect]
    plugins = load_plugins(frozenset(LIBRARY))
    if spec.effect in plugins.effects:
        return plugins.effects[spec.effect]
    if spec.effect in plugins.broken:
        message = plugins.broken[spec.effect].message
        raise InputError(message, hint="repair or reinstall that package, or leave the effect out", place=where)
    known = ", ".join(sorted(LIBRARY | plugins.effects))
    hint = f"known are: {known}; or add a formula: of your own"
    raise InputError("is no effect of the library", hint=hint, place=where)


def _read(kind: type[Effect], spec: EffectSpec, model: Model, joint: str | None, where: Place) -> dict[str, Any]:
    """The hyper-parameters of an entry, checked. A formula's are in its class already."""
    if "formula" in spec.settings:
        return {}
    hypers, settings, joints, units = kind.hypers(), spec.settings, model.joints, _units(model, joint)
    for key in settings:
        if key not in hypers:
            raise _wrong(where, key, "is not a setting of this effect", _settings_hint(hypers), settings[key])
    others = [name for name in joints if name != joint]
    out: dict[str, Any] = {}
    for key, hyper in hypers.items():
        given = settings.get(key)
        if given is None and hyper.unit == "joint" and len(others) == 1:
            given = others[0]
        if given is not None:
            out[key] = _value(hyper, given, joints, units, where, key)
        elif key not in kind.defaults():
            raise _wrong(where, key, f"is missing: {hyper.describe(units)}", f"add {key}: to this entry", None)
    return out


def _units(model: Model, joint: str | None) -> Units:
    """Units of a joint as far as the model file itself tells them."""
    kinds = model.robot.types or tuple(link.type for link in model.robot.table or ())
    at = model.joints.index(joint) if joint in model.joints else 0
    return Units(kinds[at] == "revolute" if at < len(kinds) else True)


def _value(hyper: Hyper, given: Any, joints: tuple[str, ...], units: Units, where: Place, key: str) -> Any:
    if hyper.unit == "joint":
        if given not in joints:
            raise _wrong(where, key, "is not a joint of this robot", f"joints are {', '.join(joints)}", given)
        return joints.index(given)
    try:
        return hyper.check(given)
    except ValueError as err:
        raise _wrong(where, key, str(err), hyper.describe(units), given) from None


def _settings_hint(hypers: Mapping[str, Hyper]) -> str:
    return f"its settings are {', '.join(hypers)}" if hypers else "it has none: remove it"


def _wrong(where: Place, key: str, message: str, hint: str, value: Any) -> InputError:
    shown = value if isinstance(value, str | int | float | bool) else None
    return InputError(message, hint=hint, place=Place(where.file, key=f"{where.key}.{key}", value=shown))


def describe_library() -> str:
    """The library as a Markdown table, for documentation. Units are those of a joint that turns."""
    head = ["| effect | torque | parameters | hyper-parameters | what it means |", "|---|---|---|---|---|"]
    return "\n".join(head + [_line(kind) for kind in LIBRARY.values()]) + "\n"


def example(kind: type[Effect]) -> Effect:
    """An effect of a class on the second joint of a SCARA, with hyper-parameters from its grid."""
    motion = trial_motion(2)
    motion = motion.with_model(motion.ddq, trial_values(4))
    settings = next(iter(kind.grid(motion, 1)), {name: 1.0 for name in kind.hypers()})
    return kind(None if kind.whole_arm else 1, **settings).bind(Scara(("q1", "q2")))


def _line(kind: type[Effect]) -> str:
    effect, units = example(kind), Units(True)
    named = zip(effect.symbols, effect.units(units), strict=True)
    parameters = ", ".join(symbol if unit == "1" else f"{symbol} [{unit}]" for symbol, unit in named) or "-"
    hypers = "; ".join(f"`{name}`: {hyper.describe(units)}" for name, hyper in kind.hypers().items()) or "-"
    return f"| `{kind.name}` | {kind.formula} | {parameters} | {hypers} | {kind.sentence} |"
