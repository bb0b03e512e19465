"""Effects of the user: formulas in the model file, and packages."""

import math
import sys

import numpy as np
import pytest
import yaml
from effects.motions import SCARA, known, smooth

from chebid.dynamics import Dynamics, make_dynamics
from chebid.effects import LIBRARY, all_effects, make_effects, plugins, specify
from chebid.errors import InputError
from chebid.model import Model, read_model, write_model

MOTION = known(smooth(4, count=200))


def model(*effects, joints=("q1", "q2"), **more):
    return Model.model_validate({"robot": {"type": "scara"}, "joints": joints, "effects": list(effects), **more})


STRIBECK = {
    "effect": "seal",
    "joint": "q2",
    "formula": "sign(dq)*exp(-abs(dq)/v0)",
    "hyper": {"v0": 0.1},
    "symbol": "Fm",
    "unit": "N.m",
}


# formulas -------------------------------------------------------------------------------------------------------------


def test_a_formula_is_an_effect_like_any_other():
    (mine,) = make_effects(model(STRIBECK))
    twin = LIBRARY["stribeck"](1, vs=0.1, delta=1.0)
    np.testing.assert_allclose(mine.block(MOTION), twin.block(MOTION), atol=1e-15)
    (parameter,) = mine.parameters(("q1", "q2"), (True, True))
    assert (parameter.name, parameter.joint, parameter.unit) == ("Fm2", "q2", "N.m")
    assert mine.name == "seal" and mine.kind == "user" and mine.signs == (1,) and not mine.needs_model
    assert mine.vector().tolist() == [0.1] and mine.grid(MOTION, 1) == [{"v0": 0.1}]


def test_short_form_is_on_every_joint():
    entry = {key: value for key, value in STRIBECK.items() if key != "joint"}
    effects = make_effects(model(entry))
    assert [effect.joint for effect in effects] == [0, 1] and type(effects[0]) is type(effects[1])


@pytest.mark.parametrize(
    ("formula", "column"),
    [
        ("q1 - dq2*ddq1", lambda m: m.q[:, 0] - m.dq[:, 1] * m.ddq[:, 0]),
        ("tau_model + tau_model1", lambda m: m.tau[:, 1] + m.tau[:, 0]),
        ("t", lambda m: m.t),
        ("2", lambda m: np.full(200, 2.0)),
        (3, lambda m: np.full(200, 3.0)),
        ("q*dq +\n   ddq", lambda m: m.q[:, 1] * m.dq[:, 1] + m.ddq[:, 1]),
    ],
)
def test_variables(formula, column):
    (mine,) = make_effects(model({"effect": "mine", "joint": "q2", "formula": formula}))
    np.testing.assert_array_equal(mine.columns(MOTION)[:, 0], column(MOTION))
    assert mine.needs_model == ("tau" in str(formula))


def test_several_columns():
    entry = {
        "effect": "pair",
        "joint": "q1",
        "formula": ["cos(3*q)", "sin(3*q)"],
        "symbol": ["a", "b"],
        "unit": ["N.m"] * 2,
    }
    (mine,) = make_effects(model(entry))
    np.testing.assert_allclose(mine.columns(MOTION), LIBRARY["torque_ripple"](0, k=3.0).columns(MOTION), atol=1e-15)
    assert [p.name for p in mine.parameters(("q1", "q2"), (True, True))] == ["a1", "b1"]
    (plain,) = make_effects(model({"effect": "pair", "joint": "q1", "formula": ["q", "dq"]}))
    assert [p.name for p in plain.parameters(("q1", "q2"), (True, True))] == ["pair_a1", "pair_b1"]


def test_a_range_makes_a_hyper_parameter_refinable():
    hyper = {"v0": {"value": 0.1, "low": 0.01, "high": 1.0, "unit": "rad/s"}, "n": 2}
    entry = STRIBECK | {"formula": "sign(dq)*exp(-abs(dq/v0)**n)", "hyper": hyper}
    (mine,) = make_effects(model(entry))
    assert mine.refinable(MOTION, 1) == {"v0": (0.01, 1.0)}
    grid = mine.grid(MOTION, 1)
    assert len(grid) == 5 and all(entry["n"] == 2 for entry in grid) and {"v0": 0.1, "n": 2.0} in grid
    other = type(mine)(1, v0=0.3)
    assert specify(other, ("q1", "q2")).settings["hyper"]["v0"] == hyper["v0"] | {"value": 0.3}


def test_an_entry_survives_the_model_file(tmp_path):
    first = model(STRIBECK, "viscous", {"effect": "hard_stop", "joint": "q1", "qs": 1.2, "m": 1.5})
    effects = make_effects(first)
    written = first.model_copy(update={"effects": tuple(specify(effect, first.joints) for effect in effects)})
    write_model(written, tmp_path / "m.yaml")
    again = make_effects(read_model(tmp_path / "m.yaml"))
    assert again == effects
    assert yaml.safe_load((tmp_path / "m.yaml").read_text())["effects"][0]["hyper"] == {"v0": 0.1}


BAD = [
    ({"formula": "sign(dq"}, "effects.0.formula", "never closed"),
    ({"formula": "sign(speed)"}, "effects.0.formula", "'speed' is not known.*at character 6"),
    ({"formula": "q3"}, "effects.0.formula", "'q3' is not known"),
    ({"formula": None}, "effects.0.formula", "not a text"),
    ({"formula": True}, "effects.0.formula", "not a text"),
    ({"formula": []}, "effects.0.formula", "0 formulas"),
    ({"formula": {"a": 1}}, "effects.0.formula", "not a text"),
    ({"formula": "q", "hyper": 3}, "effects.0.hyper", "mapping"),
    ({"formula": "q", "hyper": {"v0": "fast"}}, "effects.0.hyper.v0", "not a number"),
    ({"formula": "q", "hyper": {"v0": True}}, "effects.0.hyper.v0", "not a number"),
    ({"formula": "q", "hyper": {"v0": [1]}}, "effects.0.hyper.v0", "not a number"),
    ({"formula": "q", "hyper": {"dq": 1}}, "effects.0.hyper.dq", "another meaning"),
    ({"formula": "q", "hyper": {"exp": 1}}, "effects.0.hyper.exp", "another meaning"),
    ({"formula": "q", "hyper": {"joint": 1}}, "effects.0.hyper.joint", "another meaning"),
    ({"formula": "q", "hyper": {"columns": 1}}, "effects.0.hyper.columns", "another meaning"),
    ({"formula": "q", "hyper": {"lambda": 1}}, "effects.0.hyper.lambda", "another meaning"),
    ({"formula": "q", "hyper": {"__class__": 1}}, "effects.0.hyper.__class__", "cannot be a name"),
    ({"formula": "q", "hyper": {"a": {"value": 3, "low": 5, "high": 6}}}, "effects.0.hyper.a", "between low and high"),
    ({"formula": "q", "hyper": {"a": {"low": 5}}}, "effects.0.hyper.a", "no hyper-parameter"),
    ({"formula": "q", "symbol": "a b"}, "effects.0.symbol", "not a name"),
    ({"formula": ["q", "dq"], "symbol": ["a", "a"]}, "effects.0.symbol", "twice"),
    ({"formula": ["q", "dq"], "symbol": "a"}, "effects.0.symbol", "2 texts"),
    ({"formula": "q", "unit": 5}, "effects.0.unit", "one text"),
    ({"formula": "q", "colour": "red"}, "effects.0.colour", "not a key"),
    ({"formula": "q", "effect": "viscous"}, "effects.0", "effect of the library"),
    ({"formula": "q", "effect": "my name"}, "effects.0", "cannot be the name"),
]


@pytest.mark.parametrize(("entry", "key", "why"), BAD, ids=range(len(BAD)))
def test_bad_entries(entry, key, why):
    with pytest.raises(InputError, match=why) as caught:
        make_effects(model({"effect": "mine", "joint": "q1"} | entry))
    assert caught.value.place.key == key and caught.value.hint


def test_a_formula_that_is_not_finite_names_the_instant():
    (mine,) = make_effects(model({"effect": "mine", "joint": "q1", "formula": "log(q)"}))
    with pytest.raises(InputError, match=r"gives nan at t = .* s \(q = -") as caught:
        mine.columns(MOTION)
    assert "mine" in caught.value.place.key


def test_same_entry_twice():
    with pytest.raises(InputError, match="'q2' twice"):
        make_effects(model(STRIBECK, dict(STRIBECK)))


def test_identified_by_the_same_code():
    """The parameter of a user's formula from torques made with the library's effect."""
    truth = Dynamics(SCARA, (LIBRARY["stribeck"](1, vs=0.1, delta=1.0),))
    torque = truth.torque(MOTION, np.array([3.45, 0.061, 0.124, 0.008, 0.37]))
    mine = make_dynamics(model(STRIBECK))
    W = mine.regressor(MOTION).reshape(-1, len(mine.parameters))
    theta = mine.named(np.linalg.lstsq(W, torque.reshape(-1))[0])
    assert theta["Fm2"] == pytest.approx(0.37, rel=1e-10)


# other packages -------------------------------------------------------------------------------------------------------

GOOD = """
from dataclasses import dataclass
from chebid.effects import JointEffect, setting
class Cube(JointEffect):
    name = "cube"
    sentence = "grows with the third power of speed"
    symbols = ("F3",)
    def units(self, units):
        return (units.per_velocity(3),)
    def columns(self, motion):
        return motion.dq[:, [self.joint]] ** 3
class Short(Cube):
    name = "short"
    def columns(self, motion):
        return motion.dq[:-1, [self.joint]]
class Crash(Cube):
    name = "crash"
    def columns(self, motion):
        raise KeyError("secret")
class Holes(Cube):
    name = "holes"
    def columns(self, motion):
        return motion.dq[:, [self.joint]] / 0.0 * 0.0
@dataclass(frozen=True)
class Tuned(Cube):
    a: float = setting("a scale", "1", above=0)
    name = "tuned"
class Viscous(Cube):
    name = "viscous"
class Nameless(Cube):
    name = ""
class Idle(JointEffect):
    name = "idle"
    sentence = "does nothing"
class Odd(Cube):
    name = "odd"
    kind = "weather"
plain = 3
"""
POINTS = {name.lower(): f"their_effects:{name}" for name in ("Cube", "Short", "Crash", "Holes", "Tuned")}
BROKEN = {
    "viscous2": "their_effects:Viscous",
    "nameless": "their_effects:Nameless",
    "idle": "their_effects:Idle",
    "odd": "their_effects:Odd",
    "plain": "their_effects:plain",
    "absent": "their_effects:Absent",
    "nowhere": "no_such_module:X",
    "quits": "their_exit:X",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package on the path, installed as pip does it, with effects good and bad."""
    (tmp_path / "their_effects.py").write_text(GOOD)
    (tmp_path / "their_exit.py").write_text("raise SystemExit(3)")
    info = tmp_path / "their_package-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: their-package\nVersion: 1.0\n")
    lines = "\n".join(f"{name} = {value}" for name, value in (POINTS | BROKEN).items())
    (info / "entry_points.txt").write_text(f"[chebid.effects]\n{lines}\n")
    monkeypatch.syspath_prepend(tmp_path)
    plugins.load_plugins.cache_clear()
    yield
    plugins.load_plugins.cache_clear()
    for name in ("their_effects", "their_exit"):
        sys.modules.pop(name, None)


@pytest.mark.usefixtures("package")
def test_a_package_brings_effects():
    (cube,) = make_effects(model({"effect": "cube", "joint": "q2"}))
    dynamics = Dynamics(SCARA, (cube,))
    np.testing.assert_array_equal(dynamics.block(cube, MOTION)[:, 1, 0], MOTION.dq[:, 1] ** 3)
    assert dynamics.parameters[-1].unit == "N.m.s^3/rad^3"
    (tuned,) = make_effects(model({"effect": "tuned", "joint": "q2", "a": "1e-1"}))
    assert tuned.hyper == {"a": 0.1}
    with pytest.raises(InputError, match=r"is missing: a scale; above 0"):
        make_effects(model({"effect": "tuned", "joint": "q2"}))


@pytest.mark.usefixtures("package")
def test_broken_ones_give_one_notice_each_and_stop_nothing():
    effects, notices = all_effects()
    assert set(POINTS) <= set(effects) and set(LIBRARY) <= set(effects)
    ours = [str(n) for n in notices if "their-package" in str(n)]
    assert len(ours) == len(BROKEN)
    for name in BROKEN:
        assert sum(repr(name) in text for text in ours) == 1
    assert any("SystemExit" in text for text in ours) and any("no_such_module" in text for text in ours)


@pytest.mark.usefixtures("package")
def test_a_broken_one_asked_for_by_name_is_an_error():
    with pytest.raises(InputError, match=r"'absent' of their-package .* cannot be used: AttributeError"):
        make_effects(model({"effect": "absent", "joint": "q1"}))


@pytest.mark.usefixtures("package")
@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("crash", "failed: KeyError: 'secret'"),
        ("short", r"shape \(199, 1, 1\) instead of \(200, 1, 1\)"),
        ("holes", "finite"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_what_a_package_does_wrong_is_its_error(name, why):
    (effect,) = make_effects(model({"effect": name, "joint": "q1"}))
    with pytest.raises(InputError, match=why) as caught:
        Dynamics(SCARA, (effect,)).regressor(MOTION)
    assert caught.value.place.value == name and "their_effects" in caught.value.hint


def test_without_packages_nothing_is_loaded(monkeypatch):
    """Effects of the library do not look for packages."""
    monkeypatch.setattr(plugins, "entry_points", lambda **_: pytest.fail("looked for packages"))
    plugins.load_plugins.cache_clear()
    assert len(make_effects(model("viscous", STRIBECK))) == 3
    plugins.load_plugins.cache_clear()


def test_math_of_the_example_in_the_agreement():
    (mine,) = make_effects(model(STRIBECK))
    motion = MOTION.cut(slice(7, 8))
    v = float(motion.dq[0, 1])
    assert mine.columns(motion)[0, 0] == pytest.approx(math.copysign(math.exp(-abs(v) / 0.1), v), rel=1e-14)
