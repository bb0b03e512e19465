"""The formula parser: what it computes, what it refuses and where, and that nothing gets past it."""

import ast
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from chebid.effects import formula
from chebid.effects.formula import CONSTANTS, DEEPEST, FUNCTIONS, LONGEST, FormulaError, evaluate, parse

NAMES = frozenset({"t", "q", "dq", "q1", "dq2", "v0"})
VALUES = {"t": 0.5, "q": -1.25, "dq": 0.75, "q1": 2.0, "dq2": -3.0, "v0": 0.1}


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("1", 1.0),
        ("-q**2", -1.5625),
        ("(-q)**2", 1.5625),
        ("2**3**2", 512.0),
        ("7 % 4 - 7 / 4", 1.25),
        ("sign(dq)*exp(-abs(dq)/v0)", math.exp(-7.5)),
        ("where(q < 0, 10, 20)", 10.0),
        ("where(dq, 10, 20)", 10.0),
        ("0 < dq < 1", 1.0),
        ("0 < dq < 0.5", 0.0),
        ("q < 0 and dq < 0", 0.0),
        ("q < 0 or dq < 0", 1.0),
        ("not q", 0.0),
        ("min(q, dq, 2) + max(q, dq)", -0.5),
        ("atan2(dq2, q1)", math.atan2(-3, 2)),
        ("asin(0.5) + acos(0.5) - atan(1)", math.pi / 4),
        ("pi", math.pi),
        ("tanh(dq/v0)", math.tanh(7.5)),
        ("hypot(3, 4) + floor(2.7) + ceil(2.1)", 10.0),
        ("1e-3 + .5", 0.501),
    ],
)
def test_values(text, wanted):
    found = parse(text, NAMES)
    assert float(found(VALUES)) == pytest.approx(wanted, rel=1e-15)
    arrays = {name: np.full(4, value) for name, value in VALUES.items()}
    np.testing.assert_allclose(evaluate(found, arrays, 4), np.full(4, wanted), rtol=1e-15)


def test_what_a_formula_uses():
    found = parse("where(q > 0, exp(dq), t)*v0", NAMES)
    assert found.names == {"q", "dq", "t", "v0"} and found.jumps
    assert not parse("exp(q)", NAMES).jumps


REFUSED = [
    ("foo", 1, "'foo' is not known"),
    ("1 + foo", 5, "'foo' is not known"),
    ("sin", 1, "write sin"),
    ("open('x')", 1, "no such function"),
    ("q.real", 1, "a dot"),
    ("q[0]", 1, "indexing"),
    ("().__class__", 1, "a dot"),
    ("1 if q else 2", 1, "where"),
    ("lambda: 1", 1, "lambda"),
    ("q ^ 2", 5, r"\*\*"),
    ("~q", 1, "not allowed"),
    ("q & 1", 5, "not allowed"),
    ("q // 2", 6, "not allowed"),
    ("q @ q", 5, "not allowed"),
    ("q << 9", 6, "not allowed"),
    ("q in t", 6, "not allowed"),
    ("q is 1", 6, "not allowed"),
    ("sin(q, q)", 1, "takes 1 arguments"),
    ("where(q, 1)", 1, "takes 3 arguments"),
    ("sin(x=q)", 1, "plain arguments"),
    ("min(*q)", 1, "plain arguments"),
    ("min(*q, **q)", 1, "plain arguments"),
    ("'text'", 1, "not a number"),
    ("b'1'", 1, "not a number"),
    ("1j", 1, "not a number"),
    ("True", 1, "not a number"),
    ("None", 1, "not a number"),
    ("...", 1, "not a number"),
    ("f'{q}'", 1, "only numbers"),
    ("[q]", 1, "only numbers"),
    ("{q: q}", 1, "only numbers"),
    ("[q for q in t]", 1, "only numbers"),
    ("(q := 1)", 2, "only numbers"),
    ("q, t", 1, "comma"),
    ("(yield)", 2, "only numbers"),
    ("await q", 1, "only numbers"),
    ("q**21", 4, "exponents"),
    ("q**-21", 4, "exponents"),
    ("1e999", 1, "too large"),
    ("9" * 400, 1, "too large"),
    ("1 +", 4, "too early"),
    ("sin(q", 4, "never closed"),
    ("q)", 2, "missing or too much"),
    ("q = 1", 3, "missing or too much"),
    ("import os", 1, "missing or too much"),
    ("q; t", 2, "missing or too much"),
    ("", 1, "empty"),
    ("  ", 1, "empty"),
    (" q", 1, "blank"),
    ("q\n", 2, "cannot stand"),
    ("q\x00", 2, "cannot stand"),
    ("µ", 1, "cannot stand"),
    ("ｑ", 1, "cannot stand"),  # full-width q, which Python would read as q
    ("q" * (LONGEST + 1), LONGEST + 1, "at most"),
    ("(" * 400 + "q" + ")" * 400, None, "nested|missing"),
    ("-" * 300 + "q", None, "nested"),
    ("sin(" * 100 + "q" + ")" * 100, None, "nested"),
    ("__import__('os').system('true')", 1, "no such function"),
    ("abs.__globals__", 1, "a dot"),
    ("exp(q).__class__.__mro__", 1, "a dot"),
    ("eval(q)", 1, "no such function"),
]


@pytest.mark.parametrize(("text", "position", "why"), REFUSED, ids=range(len(REFUSED)))
def test_refused_with_position(text, position, why):
    with pytest.raises(FormulaError, match=why) as caught:
        parse(text, NAMES)
    assert position is None or caught.value.position == position
    assert f"at character {caught.value.position} of the formula" in str(caught.value)


def test_numbers_overflow_to_infinity_and_not_to_memory():
    """9**9**9 in whole numbers has 370 million digits; here it is inf at once."""
    assert float(parse("9**(9**9)", NAMES)({})) == math.inf
    assert math.isnan(float(parse("log(-1)", NAMES)({})))
    assert float(parse("10**20**20", NAMES)({})) == math.inf


def test_deep_but_allowed():
    depth = DEEPEST - 2
    assert float(parse("-" * depth + "q", NAMES)(VALUES)) == VALUES["q"] * (-1) ** depth


def test_a_warning_of_python_is_not_shown(recwarn):
    with pytest.raises(FormulaError):
        parse("q is 1", NAMES)
    assert not recwarn.list


# fuzz -----------------------------------------------------------------------------------------------------------------

TOKENS = [*NAMES, *FUNCTIONS, *CONSTANTS, *"+-*/%()<>=,.[]{}:;!&|^~@'\"\\ \n\t", "**", "//", "<=", "and", "not", "if"]
TOKENS += ["else", "lambda", "for", "in", "is", "1", "2.5", "1e9", "0x1f", "1_0", "None", "True", "__class__", "x", "é"]


@settings(max_examples=2000)
@given(st.lists(st.sampled_from(TOKENS), max_size=25).map("".join) | st.text(max_size=40))
@example("1if q else 2")
@example("q\\\n")
@example("0777")
def test_any_text_is_a_formula_or_an_error(text):
    """No other exception, no name beyond those given, and an evaluation that ends in numbers."""
    try:
        found = parse(text, NAMES)
    except FormulaError:
        return
    assert found.names <= NAMES
    assert np.asarray(found(VALUES), dtype=float).shape == ()
    for node in ast.walk(ast.parse(text, mode="eval")):
        assert not isinstance(node, ast.Attribute | ast.Subscript | ast.Lambda | ast.Starred | ast.keyword)


def grow(inner):
    """Pairs of a formula and its value, computed beside it."""
    two = st.tuples(inner, inner)
    return st.one_of(
        two.map(lambda p: (f"({p[0][0]} + {p[1][0]})", p[0][1] + p[1][1])),
        two.map(lambda p: (f"({p[0][0]} - {p[1][0]})", p[0][1] - p[1][1])),
        two.map(lambda p: (f"({p[0][0]} * {p[1][0]})", p[0][1] * p[1][1])),
        two.map(lambda p: (f"max({p[0][0]}, {p[1][0]})", max(p[0][1], p[1][1]))),
        two.map(lambda p: (f"({p[0][0]} < {p[1][0]})", float(p[0][1] < p[1][1]))),
        inner.map(lambda p: (f"-{p[0]}" if p[0][0] != "-" else f"-({p[0]})", -p[1])),
        inner.map(lambda p: (f"tanh({p[0]})", math.tanh(p[1]))),
        inner.map(lambda p: (f"abs({p[0]})", abs(p[1]))),
        st.tuples(inner, inner, inner).map(
            lambda p: (f"where({p[0][0]} > 0, {p[1][0]}, {p[2][0]})", p[1][1] if p[0][1] > 0 else p[2][1])
        ),
    )


LEAVES = st.sampled_from(sorted(VALUES.items())) | st.floats(0.01, 10).map(lambda x: (repr(x), x))


@settings(max_examples=300)
@given(st.recursive(LEAVES, grow, max_leaves=20))
def test_values_of_random_formulas(pair):
    text, wanted = pair
    if len(text) <= LONGEST:
        assert float(parse(text, NAMES)(VALUES)) == pytest.approx(wanted, rel=1e-12, abs=1e-12)


def test_the_parser_has_no_way_out():
    """The source calls neither eval, exec nor compile, and getattr only on numpy with names of its own."""
    tree = ast.parse(Path(formula.__file__).read_text())
    called = {node.func.id for node in ast.walk(tree) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    assert not called & {"eval", "exec", "compile", "__import__", "open", "setattr", "globals", "vars"}
