"""Formulas of the user: arithmetic on arrays, and nothing else.

A formula is parsed by Python's own parser and then rebuilt node by node from a list of what is allowed: numbers,
named variables, + - * / % **, comparisons, and, or, not, and the functions below. Everything else (attributes,
indexing, other names, text, lambda ...) is an error that names the position. Numbers are floats from the start, so
that no power grows beyond 1e308; length, depth and constant exponents are limited. Nothing is ever executed but the
functions listed here.
"""

import ast
import operator
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from chebid.robots import Array

LONGEST = 1000  # characters
DEEPEST = 40  # nested operations
STEEPEST = 20  # constant exponents

Value = Any  # a float or an array: numpy treats them alike
Node = Callable[[Mapping[str, Value]], Value]


class FormulaError(ValueError):
    """What is wrong with a formula, and at which character (from 1)."""

    def __init__(self, message: str, position: int) -> None:
        self.position = position
        super().__init__(f"{message} (at character {position} of the formula)")


def _where(condition: Value, yes: Value, no: Value) -> Value:
    return np.where(np.not_equal(condition, 0), yes, no)


def _least(*values: Value) -> Value:
    return reduce(np.minimum, values)


def _largest(*values: Value) -> Value:
    return reduce(np.maximum, values)


#: name -> (function, fewest and most arguments)
FUNCTIONS: dict[str, tuple[Callable[..., Value], int, int]] = {
    **{name: (getattr(np, name), 1, 1) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "sqrt")},
    **{name: (getattr(np, f"arc{name[1:]}"), 1, 1) for name in ("asin", "acos", "atan")},
    "atan2": (np.arctan2, 2, 2),
    "hypot": (np.hypot, 2, 2),
    "abs": (np.abs, 1, 1),
    "sign": (np.sign, 1, 1),
    "floor": (np.floor, 1, 1),
    "ceil": (np.ceil, 1, 1),
    "min": (_least, 2, 10),
    "max": (_largest, 2, 10),
    "where": (_where, 3, 3),
}
_JUMPS = {"sign", "floor", "ceil", "where"}
CONSTANTS = {"pi": float(np.pi)}

_BINARY: dict[type[ast.operator], Callable[[Value, Value], Value]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: np.divide,
    ast.Mod: np.mod,
    ast.Pow: np.power,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Value, Value], Value]] = {
    ast.Lt: np.less,
    ast.LtE: np.less_equal,
    ast.Gt: np.greater,
    ast.GtE: np.greater_equal,
    ast.Eq: np.equal,
    ast.NotEq: np.not_equal,
}


@dataclass(frozen=True)
class Formula:
    """A checked formula: `text`, the `names` of the variables it uses, and whether its value may jump."""

    text: str
    names: frozenset[str]
    jumps: bool
    _node: Node

    def __call__(self, values: Mapping[str, Value]) -> Value:
        """Evaluate for values of its names: floats, or arrays (N,). Not finite where the formula is not."""
        with np.errstate(all="ignore"):
            return self._node(values)


def parse(text: str, variables: frozenset[str]) -> Formula:
    """Check a formula over `variables`. Raises FormulaError."""
    tree = _tree(text)
    checker = _Checker(variables)
    node = checker.build(tree, 1)
    return Formula(text, frozenset(checker.names), checker.jumps, node)


def _tree(text: str) -> ast.expr:
    if len(text) > LONGEST:
        raise FormulaError(f"a formula has at most {LONGEST} characters, this one {len(text)}", LONGEST + 1)
    for at, character in enumerate(text):
        if not (" " <= character <= "~"):
            raise FormulaError(f"{character!r} cannot stand in a formula", at + 1)
    if not text.strip():
        raise FormulaError("the formula is empty", 1)
    if text[0] == " ":  # Python's parser takes a leading blank for an indentation
        raise FormulaError("the formula begins with a blank", 1)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # 1if x else y, "is" with a number: refused below anyway
            return ast.parse(text, mode="eval").body
    except SyntaxError as err:
        raise _unreadable(err, text) from None
    except (ValueError, MemoryError, RecursionError):
        raise FormulaError("is too deeply nested", 1) from None


def _unreadable(err: SyntaxError, text: str) -> FormulaError:
    if not err.offset:
        return FormulaError("ends too early: something is missing", len(text) + 1)
    if "never closed" in err.msg:
        return FormulaError("a bracket is never closed", err.offset)
    return FormulaError("is not a formula: something is missing or too much", max(1, min(err.offset, len(text) + 1)))


class _Checker:
    """Rebuilds a syntax tree as closures, refusing all that is not listed."""

    def __init__(self, variables: frozenset[str]) -> None:
        self.variables = variables
        self.names: set[str] = set()
        self.jumps = False

    def build(self, node: ast.expr, depth: int) -> Node:
        if depth > DEEPEST:
            raise _refuse(node, f"is nested deeper than {DEEPEST} operations")
        builder = {
            ast.Constant: self._number,
            ast.Name: self._name,
            ast.UnaryOp: self._unary,
            ast.BinOp: self._binary,
            ast.Compare: self._compare,
            ast.BoolOp: self._bool,
            ast.Call: self._call,
        }.get(type(node))
        if builder is None:
            raise _refuse(node, _not_allowed(node))
        return builder(node, depth + 1)  # type: ignore[operator]

    def _number(self, node: ast.Constant, depth: int) -> Node:
        if type(node.value) not in (int, float):
            raise _refuse(node, f"{node.value!r:.20} is not a number")
        try:
            value = float(node.value)  # type: ignore[arg-type]
        except OverflowError:
            value = np.inf
        if not np.isfinite(value):
            raise _refuse(node, "this number is too large")
        return lambda values: value

    def _name(self, node: ast.Name, depth: int) -> Node:
        name = node.id
        if name in CONSTANTS:
            constant = CONSTANTS[name]
            return lambda values: constant
        if name in FUNCTIONS:
            raise _refuse(node, f"{name} is a function: write {name}(...)")
        if name not in self.variables:
            known = ", ".join(sorted(self.variables, key=lambda n: (len(n), n)))
            raise _refuse(node, f"{name!r:.40} is not known; known are {known}")
        self.names.add(name)
        return lambda values: values[name]

    def _unary(self, node: ast.UnaryOp, depth: int) -> Node:
        operand = self.build(node.operand, depth)
        if isinstance(node.op, ast.USub):
            return lambda values: np.negative(operand(values))
        if isinstance(node.op, ast.UAdd):
            return operand
        if isinstance(node.op, ast.Not):
            return lambda values: np.equal(operand(values), 0) * 1.0
        raise _refuse(node, "~ is not allowed")

    def _binary(self, node: ast.BinOp, depth: int) -> Node:
        act = _BINARY.get(type(node.op))
        if act is None:
            hint = "write ** for a power" if isinstance(node.op, ast.BitXor) else "use + - * / % **"
            raise _refuse(node.right, f"this operation is not allowed: {hint}")
        if isinstance(node.op, ast.Pow):
            _check_exponent(node.right)
        left, right = self.build(node.left, depth), self.build(node.right, depth)
        return lambda values: act(left(values), right(values))

    def _compare(self, node: ast.Compare, depth: int) -> Node:
        self.jumps = True
        parts = [self.build(part, depth) for part in (node.left, *node.comparators)]
        acts = []
        for op, part in zip(node.ops, node.comparators, strict=True):
            if type(op) not in _COMPARE:
                raise _refuse(part, "this comparison is not allowed: use < <= > >= == !=")
            acts.append(_COMPARE[type(op)])

        def compare(values: Mapping[str, Value]) -> Value:
            sides = [part(values) for part in parts]
            pairs = zip(acts, sides[:-1], sides[1:], strict=True)
            return reduce(operator.mul, (act(a, b) * 1.0 for act, a, b in pairs))

        return compare

    def _bool(self, node: ast.BoolOp, depth: int) -> Node:
        parts = [self.build(part, depth) for part in node.values]
        join = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return lambda values: reduce(join, (np.not_equal(part(values), 0) for part in parts)) * 1.0

    def _call(self, node: ast.Call, depth: int) -> Node:
        if not isinstance(node.func, ast.Name) or node.func.id not in FUNCTIONS:
            raise _refuse(node.func, f"no such function; there are {', '.join(sorted(FUNCTIONS))}")
        name = node.func.id
        act, least, most = FUNCTIONS[name]
        if node.keywords or any(isinstance(argument, ast.Starred) for argument in node.args):
            raise _refuse(node, f"{name} takes plain arguments")
        if not least <= len(node.args) <= most:
            wanted = f"{least}" if least == most else f"{least} to {most}"
            raise _refuse(node, f"{name} takes {wanted} arguments, not {len(node.args)}")
        self.jumps = self.jumps or name in _JUMPS
        arguments = [self.build(argument, depth) for argument in node.args]
        return lambda values: act(*(argument(values) for argument in arguments))


def _check_exponent(node: ast.expr) -> None:
    inner = node.operand if isinstance(node, ast.UnaryOp) else node
    if isinstance(inner, ast.Constant) and type(inner.value) in (int, float) and abs(inner.value) > STEEPEST:  # type: ignore[arg-type]
        raise _refuse(node, f"exponents go up to {STEEPEST}")


def _refuse(node: ast.expr, message: str) -> FormulaError:
    return FormulaError(message, node.col_offset + 1)


def _not_allowed(node: ast.expr) -> str:
    words = {
        ast.Attribute: "attributes (a dot) are not allowed",
        ast.Subscript: "indexing is not allowed: other joints are q1, dq1 ...",
        ast.IfExp: "if ... else is not allowed: write where(condition, a, b)",
        ast.Tuple: "a comma does not belong here",
        ast.Lambda: "lambda is not allowed",
    }
    return words.get(type(node), "only numbers, names, operations and functions are allowed")


def evaluate(formula: Formula, values: Mapping[str, Value], count: int) -> Array:
    """(N,): the formula at N samples, also where it is a constant."""
    return np.broadcast_to(np.asarray(formula(values), dtype=float), (count,))
