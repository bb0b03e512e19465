"""Effects of the user, as formulas in the model file:

    - {effect: seal, joint: q1, formula: "sign(dq)*exp(-abs(dq)/v0)", hyper: {v0: 0.1}, symbol: Fm, unit: N.m}

over t, q, dq, ddq and tau_model of the joint, and q1, dq1, ddq1, tau_model1, ... of any joint, numbered in their order
from 1. Several columns: a list of formulas, with lists of symbols and units. A hyper-parameter is a number, or a
mapping {value: , low: , high: , unit: }, whose range it may be refined in. `sentence` says what it is.

Each entry becomes a class of its own, so that it passes through the same code as the library.
"""

import dataclasses
import functools
import json
import keyword
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from chebid.effects.effect import JointEffect
from chebid.effects.formula import CONSTANTS, FUNCTIONS, Formula, FormulaError, evaluate, parse
from chebid.effects.hyper import Extent, Hyper, number
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.errors import InputError, Place
from chebid.robots import Array

_KEYS = ("formula", "hyper", "symbol", "unit", "sentence")
_STATE = ("t", "q", "dq", "ddq", "tau_model")
_MOST = 20  # formulas, or hyper-parameters, of one effect
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")


@dataclass(frozen=True)
class FormulaEffect(JointEffect):
    """Base of the classes made from formulas."""

    kind = "user"
    formulas: ClassVar[tuple[Formula, ...]] = ()
    given_units: ClassVar[tuple[str, ...]] = ()
    source: ClassVar[dict[str, Any]] = {}
    ranges: ClassVar[dict[str, Any]] = {}

    @functools.cached_property
    def _used(self) -> frozenset[str]:
        return frozenset().union(*(formula.names for formula in self.formulas))

    @property
    def forward(self) -> str:
        return ""  # the general path: the formula itself

    @property
    def needs_model(self) -> bool:
        return any(name.startswith("tau_model") for name in self._used)

    @property
    def signs(self) -> tuple[int, ...]:
        """Joints whose velocity it uses, where a function of it may jump."""
        if not any(formula.jumps for formula in self.formulas):
            return ()
        numbers = {self.joint if name == "dq" else int(name[2:]) - 1 for name in self._used if _is_speed(name)}
        return tuple(sorted(numbers))

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        """The value given; with a range, five values of it."""
        return {name: _spread(cls.defaults()[name], cls.hypers()[name]) for name in cls.hypers()}

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        return {n: (h.low, h.high) for n, h in cls.hypers().items() if np.isfinite(h.low) and np.isfinite(h.high)}

    def settings(self, joints: tuple[str, ...]) -> dict[str, Any]:
        values = super().settings(joints)
        given = self.source.get("hyper", {})
        hyper = {n: given[n] | {"value": v} if isinstance(given[n], dict) else v for n, v in values.items()}
        return self.source | ({"hyper": hyper} if hyper else {})

    def units(self, units: Units) -> tuple[str, ...]:
        return self.given_units

    def columns(self, motion: Motion) -> Array:
        values = self._values(motion)
        columns = np.column_stack([evaluate(formula, values, len(motion)) for formula in self.formulas])
        self._check(columns, motion)
        return columns

    def _values(self, motion: Motion) -> dict[str, Any]:
        return self.hyper | {name: _variable(motion, name, self.joint) for name in self._used if name not in self.hyper}

    def _check(self, columns: Array, motion: Motion) -> None:
        bad = ~np.isfinite(columns)
        if bad.any():
            row, which = np.argwhere(bad)[0]
            q, dq = motion.q[row, self.joint], motion.dq[row, self.joint]
            raise InputError(
                f"the formula gives {columns[row, which]} at t = {motion.t[row]:.6g} s (q = {q:.4g}, dq = {dq:.4g})",
                hint="keep it finite, for instance with max(abs(dq), 1e-6) in a denominator",
                place=Place(key=f"effects: {self.name}: formula", value=self.formulas[which].text),
            )


def _is_speed(name: str) -> bool:
    return re.fullmatch(r"dq\d*", name) is not None


def _variable(motion: Motion, name: str, joint: int) -> Array:
    if name == "t":
        return motion.t
    base = name.rstrip("0123456789")
    at = int(name[len(base) :]) - 1 if base != name else joint
    array = {"q": motion.q, "dq": motion.dq, "ddq": motion.ddq, "tau_model": motion.tau}[base]
    assert array is not None, "Dynamics completes the motion"
    return array[:, at]


def _spread(value: float, hyper: Hyper) -> Iterable[float]:
    if not (np.isfinite(hyper.low) and np.isfinite(hyper.high)):
        return (value,)
    scale = np.geomspace if hyper.low > 0 else np.linspace
    return tuple(sorted({value, *scale(hyper.low, hyper.high, 5).tolist()}))


# from the model file ------------------------------------------------------------------------------------------------


def formula_effect(name: str, settings: Mapping[str, Any], joints: int, where: Place) -> type[FormulaEffect]:
    """The class of an entry with a formula, for a robot of so many joints. Raises InputError naming key and place.

    Equal entries give the same class.
    """
    try:
        frozen = json.dumps(settings, sort_keys=True, allow_nan=False)
    except (TypeError, ValueError):
        message = "has settings that are not plain text and numbers"
        raise InputError(message, hint="see the README", place=where) from None
    try:
        return _make(name, frozen, joints)
    except InputError as err:
        key = f"{where.key}.{err.place.key}" if err.place.key else where.key
        value = where.value if err.place.value is None else err.place.value
        raise InputError(err.message, hint=err.hint, place=dataclasses.replace(where, key=key, value=value)) from None


@functools.lru_cache(maxsize=64)
def _make(name: str, frozen: str, joints: int) -> type[FormulaEffect]:
    settings = json.loads(frozen)
    for key in settings:
        if key not in _KEYS:
            raise _error(key, "is not a key of an effect with a formula", f"the keys are {', '.join(_KEYS)}")
    if not _NAME.fullmatch(name):
        raise _error("", "cannot be the name of an effect", "use letters, digits and _, beginning with a letter")
    hyper = _hypers(settings.get("hyper", {}))
    numbered = (f"{part}{i + 1}" for part in _STATE[1:] for i in range(joints))
    variables = frozenset((*_STATE, *numbered))
    taken = variables | set(FUNCTIONS) | set(CONSTANTS) | set(keyword.kwlist) | set(dir(FormulaEffect)) | {"joint"}
    for key in hyper:
        if key in taken:
            raise _error(f"hyper.{key}", "is a name with another meaning", "choose another name")
    formulas = _formulas(settings.get("formula"), variables | set(hyper))
    symbols = _texts(settings, "symbol", _default_symbols(name, len(formulas)))
    for symbol in symbols:
        if not _NAME.fullmatch(symbol) or len(set(symbols)) < len(symbols):
            raise _error("symbol", "is not a name, or stands there twice", "use letters and digits", symbol)
    attributes = {
        "__doc__": f"{name}: {'; '.join(formula.text for formula in formulas)}.",
        "__module__": __name__,
        "name": name,
        "formula": "; ".join(formula.text for formula in formulas),
        "sentence": _texts(settings, "sentence", ("an effect of the user's own",), one=True)[0],
        "formulas": formulas,
        "symbols": symbols,
        "given_units": _texts(settings, "unit", ("",) * len(formulas)),
        "source": settings,
    }
    fields = [(k, float, dataclasses.field(default=value, metadata={"hyper": h})) for k, (value, h) in hyper.items()]
    return dataclasses.make_dataclass(name, fields, bases=(FormulaEffect,), namespace=attributes, frozen=True)


def _default_symbols(name: str, count: int) -> tuple[str, ...]:
    return (f"{name}_",) if count == 1 else tuple(f"{name}_{chr(ord('a') + i)}" for i in range(count))


def _formulas(given: Any, variables: frozenset[str]) -> tuple[Formula, ...]:
    texts = given if isinstance(given, list) else [given]
    if not 0 < len(texts) <= _MOST:
        raise _error("formula", f"has {len(texts)} formulas", f"give one, or a list of up to {_MOST}")
    out = []
    for text in texts:
        if isinstance(text, int | float) and not isinstance(text, bool):
            text = repr(text)
        if not isinstance(text, str):
            raise _error("formula", "is not a text", 'write it in quotes, as in "sign(dq)"', text)
        try:
            out.append(parse(" ".join(text.split()), variables))
        except FormulaError as err:
            raise _error("formula", str(err), "correct the formula in the model file", text) from None
    return tuple(out)


def _hypers(given: Any) -> dict[str, tuple[float, Hyper]]:
    if not isinstance(given, dict) or len(given) > _MOST:
        raise _error("hyper", "is not a short mapping of names to numbers", "write for instance {v0: 0.1}")
    return {key: _hyper(key, value) for key, value in given.items()}


def _hyper(key: str, given: Any) -> tuple[float, Hyper]:
    if not _NAME.fullmatch(key):
        raise _error(f"hyper.{key}", "cannot be a name", "use letters, digits and _")
    parts = given if isinstance(given, dict) else {"value": given}
    unknown = set(parts) - {"value", "low", "high", "unit"}
    if unknown or "value" not in parts:
        raise _error(f"hyper.{key}", "is no hyper-parameter", "give a number, or value, low, high and unit")
    try:
        value, low, high = (number(parts.get(part, other)) for part, other in (("value", 0), ("low", 0), ("high", 0)))
    except ValueError as err:
        raise _error(f"hyper.{key}", str(err), "give finite numbers", given) from None
    low, high = (low if "low" in parts else -np.inf), (high if "high" in parts else np.inf)
    if not low <= value <= high or low == high:
        raise _error(f"hyper.{key}", "is not between low and high", "correct its range", value)
    return value, Hyper("a number of the formula", str(parts.get("unit", "1")), low, high)


def _texts(settings: Mapping[str, Any], key: str, default: tuple[str, ...], one: bool = False) -> tuple[str, ...]:
    """A text or a list of as many as there are formulas."""
    given = settings.get(key)
    if given is None:
        return default
    texts = given if isinstance(given, list) and not one else [given]
    if len(texts) != len(default) or not all(isinstance(text, str) and len(text) < 200 for text in texts):
        wanted = "one text" if len(default) == 1 else f"{len(default)} texts, one per formula"
        raise _error(key, f"is not {wanted}", "correct it in the model file", given)
    return tuple(texts)


def _error(key: str, message: str, hint: str, value: Any = None) -> InputError:
    shown = value if isinstance(value, str | int | float | bool) else None
    return InputError(message, hint=hint, place=Place(key=key, value=shown))
