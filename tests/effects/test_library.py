"""From the model file to effects and back: what is read, what is refused and where, and the grids."""

import subprocess
import sys

import numpy as np
import pytest
from effects.motions import SCARA, all_of, known, label, smooth
from hypothesis import given, settings
from hypothesis import strategies as st

from chebid.effects import LIBRARY, Extent, Motion, describe_library, find_limit, make_effects, saturated, specify
from chebid.effects.hyper import Hyper, extent, number
from chebid.errors import InputError
from chebid.model import Model, read_model, write_model

MOTION = known(smooth(12, count=1000))
# effects.md: the canonical names
NAMES = [
    "viscous", "coulomb", "offset", "viscous_asymmetry", "stribeck", "viscous_quadratic", "viscous_power",
    "load_friction", "friction_ripple", "torque_ripple", "presliding", "viscous_coupling", "coulomb_coupling",
    "coulomb_drift", "viscous_drift", "spring", "cubic_spring", "hard_stop", "base_tilt", "payload", "rotor_inertia",
    "torque_delay", "torque_gain", "saturation", "joint_flexibility", "backlash", "external_push",
]  # fmt: skip


def model(*effects, robot="scara", joints=("q1", "q2"), **more):
    return Model.model_validate({"robot": {"type": robot}, "joints": joints, "effects": list(effects), **more})


def test_all_effects_are_there():
    assert set(NAMES) | {"motor_coupling"} == set(LIBRARY)
    assert all(kind.name == name for name, kind in LIBRARY.items())


@pytest.mark.parametrize("kind", LIBRARY.values(), ids=LIBRARY)
def test_each_says_what_it_is(kind):
    assert kind.kind in {"friction", "position", "transmission", "channel", "load", "time"}
    assert 30 < len(kind.sentence) < 130 and kind.sentence[0].islower() and not kind.sentence.endswith(".")
    assert kind.formula and kind.__doc__ and set(kind.alike) <= set(LIBRARY) - {kind.name}
    assert set(kind.positive) <= set(kind.symbols)
    for name, hyper in kind.hypers().items():
        assert hyper.meaning and hyper.unit, name


def test_the_pairs_that_look_alike_are_known():
    """effects.md, the pairs; from one side or the other."""
    pairs = (
        "spring-base_tilt spring-cubic_spring spring-hard_stop viscous_quadratic-viscous_power stribeck-viscous_power"
    )
    pairs += (
        " stribeck-presliding viscous_coupling-coulomb_coupling coulomb_drift-viscous_drift backlash-joint_flexibility"
    )
    for pair in pairs.split():
        one, other = pair.split("-")
        assert other in LIBRARY[one].alike or one in LIBRARY[other].alike, pair


def test_documentation_lists_everything():
    text = describe_library()
    lines = text.splitlines()
    assert len(lines) == 2 + len(LIBRARY) and all(line.count("|") == 6 for line in lines)
    for kind in LIBRARY.values():
        line = next(line for line in lines if line.startswith(f"| `{kind.name}` |"))
        assert kind.sentence in line and all(f"`{name}`" in line for name in kind.hypers())
    assert "Fv [N.m.s/rad]" in text and "k [N.m/rad]" in text and "[rad/s]" in text


def test_no_compiler_is_imported():
    """Numba costs a second; identification must not pay for what only the simulator needs."""
    code = "import sys, chebid.effects, chebid.dynamics; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


# grids ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", LIBRARY.values(), ids=LIBRARY)
def test_grids_are_valid_and_their_columns_are_finite(kind):
    """Every entry passes the check of the model file, and shows something on this motion."""
    for joint in [None] if kind.whole_arm else [0, 1]:
        grid = kind.grid(MOTION, joint)
        assert len(grid) == len({tuple(entry.values()) for entry in grid})
        assert len(grid) <= 110
        for entry, effect in zip(grid, kind.candidates(MOTION, joint), strict=True):
            assert set(entry) <= set(kind.hypers()) and set(kind.hypers()) - set(entry) <= set(kind.defaults())
            for name, value in entry.items():
                hyper = kind.hypers()[name]
                assert type(value) in (int, float, type(None))
                assert value is None or hyper.unit == "joint" or hyper.check(value) == value
            block = effect.bind(SCARA).block(MOTION)
            assert np.isfinite(block).all() and (np.abs(block).max(axis=(0, 1)) > 0).all(), label(effect)


@pytest.mark.parametrize("kind", LIBRARY.values(), ids=LIBRARY)
def test_bounds_of_refinement_hold_the_grid(kind):
    for joint in [None] if kind.whole_arm else [0, 1]:
        grid, bounds = kind.grid(MOTION, joint), kind.refinable(MOTION, joint)
        for name, (low, high) in bounds.items():
            hyper = kind.hypers()[name]
            assert hyper.continuous and hyper.allows(low) and hyper.allows(high) and low < high
            assert all(low <= entry[name] <= high for entry in grid if entry.get(name) is not None)


def test_grids_scale_with_the_motion():
    """effects.md: Stribeck velocity from the gate to a third of the top speed, drift from T/20 to T, and so on."""
    top = float(np.percentile(np.abs(MOTION.dq[:, 0]), 95))
    velocities = [entry["vs"] for entry in LIBRARY["stribeck"].grid(MOTION, 0, gate=0.05)]
    assert min(velocities) == pytest.approx(0.05) and max(velocities) == pytest.approx(top / 3)
    constants = [entry["T"] for entry in LIBRARY["coulomb_drift"].grid(MOTION, 0)]
    assert min(constants) == pytest.approx(1.0) and max(constants) == pytest.approx(20.0)
    low, high = MOTION.q[:, 0].min(), MOTION.q[:, 0].max()
    stops = [(entry["s"], entry["qs"]) for entry in LIBRARY["hard_stop"].grid(MOTION, 0)]
    assert all((high - qs if s > 0 else qs - low) <= 0.35 * (high - low) * (1 + 1e-12) for s, qs in stops)
    assert {entry["t0"] for entry in LIBRARY["payload"].grid(MOTION, None)} >= {None}
    assert [entry["source"] for entry in LIBRARY["viscous_coupling"].grid(MOTION, 1)] == [0]


def test_ripple_grid_misses_no_wave():
    """Any wave between the ends of the grid correlates with its nearest grid wave by more than 0.8 on an even sweep."""
    q = np.linspace(-1.2, 1.5, 3000)
    motion = Motion(np.linspace(0, 20, 3000), q[:, None], np.gradient(q, 20 / 2999)[:, None], 0 * q[:, None])
    grid = [e["k"] for e in LIBRARY["torque_ripple"].grid(motion, 0) if e["harmonics"] == 1]
    bases = [np.linalg.qr(np.column_stack([np.cos(k * q), np.sin(k * q)]))[0] for k in grid]
    for k in np.random.default_rng(0).uniform(grid[1], grid[-1], 50):
        x = np.sin(k * q + 1)
        assert max(np.linalg.norm(basis.T @ x) for basis in bases) > 0.8 * np.linalg.norm(x), k


def test_a_joint_that_rests_has_a_grid_still():
    """No division by zero on a joint that never moves."""
    zero = np.zeros((50, 1))
    motion = Motion(np.linspace(0, 1, 50), zero, zero, zero, zero, np.ones(1))
    for kind in LIBRARY.values():
        for entry in kind.grid(motion, None if kind.whole_arm else 0):
            assert all(value is None or np.isfinite(value) for value in entry.values())


# model files ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("effect", all_of(MOTION), ids=label)
def test_entries_survive_the_model_file(effect, tmp_path):
    path = tmp_path / "m.yaml"
    write_model(model(specify(effect, ("q1", "q2"))), path)
    (again,) = make_effects(read_model(path))
    assert again == effect and hash(again) == hash(effect)
    assert again.vector().tolist() == effect.vector().tolist()


def test_short_form_and_file_order():
    effects = make_effects(model("viscous", {"effect": "stribeck", "joint": "q2", "vs": 0.1}, "torque_delay"))
    assert [(e.name, e.joint) for e in effects] == [
        ("viscous", 0),
        ("viscous", 1),
        ("stribeck", 1),
        ("torque_delay", None),
    ]
    assert effects[2].hyper == {"vs": 0.1, "delta": 2.0}


def test_text_that_yaml_does_not_take_for_a_number():
    (effect,) = make_effects(model({"effect": "stribeck", "joint": "q1", "vs": "1e-2"}))
    assert effect.vs == 0.01


def test_two_joints_have_one_other():
    """On a robot of two joints the source of a coupling is known; on one of three it must be named."""
    effects = make_effects(model("viscous_coupling"))
    assert [(e.joint, e.source) for e in effects] == [(0, 1), (1, 0)]
    three = {"robot": "axes", "joints": ("a", "b", "c")}
    with pytest.raises(InputError, match="is missing: the joint whose motion causes it"):
        make_effects(model({"effect": "viscous_coupling", "joint": "a"}, **three))
    (effect,) = make_effects(model({"effect": "viscous_coupling", "joint": "a", "source": "c"}, **three))
    assert effect.source == 2 and effect.settings(("a", "b", "c")) == {"source": "c"}
    assert [e.joint for e in make_effects(model({"effect": "viscous_coupling", "source": "b"}, **three))] == [0, 2]


BAD = [
    ({"effect": "stribek", "joint": "q1"}, "effects.0", "no effect of the library"),
    ({"effect": "stribeck", "joint": "q1"}, "effects.0.vs", r"missing: Stribeck velocity.*\[rad/s\]; above 0"),
    ({"effect": "stribeck", "joint": "q1", "vs": 0}, "effects.0.vs", "out of range"),
    ({"effect": "stribeck", "joint": "q1", "vs": "fast"}, "effects.0.vs", "not a number"),
    ({"effect": "stribeck", "joint": "q1", "vs": [1]}, "effects.0.vs", "not a number"),
    ({"effect": "stribeck", "joint": "q1", "vs": True}, "effects.0.vs", "not a number"),
    ({"effect": "stribeck", "joint": "q1", "vs": "inf"}, "effects.0.vs", "finite"),
    ({"effect": "stribeck", "joint": "q1", "vs": 0.1, "k": 2}, "effects.0.k", "not a setting"),
    ({"effect": "viscous", "joint": "q1", "vs": 0.1}, "effects.0.vs", "not a setting"),
    ({"effect": "viscous_power", "joint": "q1", "alpha": 1}, "effects.0.alpha", "out of range"),
    ({"effect": "torque_ripple", "joint": "q1", "k": 3, "harmonics": 1.5}, "effects.0.harmonics", "whole"),
    ({"effect": "torque_ripple", "joint": "q1", "k": 3, "harmonics": 10**9}, "effects.0.harmonics", "range"),
    ({"effect": "hard_stop", "joint": "q1", "qs": 1, "s": 2}, "effects.0.s", "out of range"),
    ({"effect": "viscous_coupling", "joint": "q1", "source": "q9"}, "effects.0.source", "not a joint"),
    ({"effect": "viscous_coupling", "joint": "q1", "source": "q1"}, "effects.0.source", "joint itself"),
    ({"effect": "payload", "joint": "q1"}, "effects.0", "whole arm"),
]


@pytest.mark.parametrize(("entry", "key", "why"), BAD, ids=range(len(BAD)))
def test_refused_entries_name_the_key(entry, key, why):
    with pytest.raises(InputError, match=why) as caught:
        make_effects(model(entry))
    assert caught.value.place.key == key and caught.value.hint


def test_units_in_messages_are_those_of_the_joint():
    with pytest.raises(InputError, match=r"\[m/s\]"):
        make_effects(
            Model.model_validate(
                {"robot": {"type": "axes", "types": ["prismatic"]}, "joints": ["x"], "effects": ["stribeck"]}
            )
        )


def test_twice_is_refused_and_two_of_a_kind_are_not():
    with pytest.raises(InputError, match="on joint 'q2' twice"):
        make_effects(model("viscous", {"effect": "viscous", "joint": "q2"}))
    with pytest.raises(InputError, match=r"^.*value 'torque_delay': is twice"):
        make_effects(model("torque_delay", "torque_delay"))
    two = [{"effect": "torque_ripple", "joint": "q1", "k": k} for k in (3, 5)]
    assert len(make_effects(model(*two))) == 2


@settings(max_examples=300)
@given(
    st.dictionaries(
        st.sampled_from(["vs", "k", "delta", "source", "t0", "formula", "hyper", "unit", "symbol", "x"]),
        st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False)
        | st.text(max_size=8) | st.lists(st.integers(), max_size=2)
        | st.dictionaries(st.text(max_size=3), st.integers(), max_size=2),
        max_size=4,
    ),
    st.sampled_from([*LIBRARY, "mine", "x y"]),
    st.sampled_from([None, "q1", "q2"]),
)  # fmt: skip
def test_any_entry_is_an_effect_or_an_input_error(extra, name, joint):
    try:
        effects = make_effects(model({"effect": name, "joint": joint} | extra))
    except InputError as err:
        assert err.hint and err.place.key.startswith("effects.0")
    else:
        assert effects


# parts ----------------------------------------------------------------------------------------------------------------


def test_ranges_in_words():
    assert Hyper("x", "1", 0, 1, open_low=True).range() == "above 0 up to 1"
    assert Hyper("x", "1", 1, 5, whole=True).range() == "a whole number from 1 up to 5"
    assert Hyper("x", "1").range() == "any number"
    assert Hyper("x", "1", choices=(-1, 1)).range() == "-1 or 1"


@given(st.floats(allow_nan=False, allow_infinity=False) | st.integers(-(10**6), 10**6))
def test_numbers_come_as_they_are_or_as_text(value):
    assert number(value) == value == number(repr(value))


@pytest.mark.parametrize("bad", [None, "", "nan", "1e999", "x", b"1", [], {}, True, 10**400])
def test_not_numbers(bad):
    with pytest.raises(ValueError, match="number"):
        number(bad)


def test_extent():
    t = np.linspace(0, 2, 201)
    found = extent(t, np.sin(t), np.cos(t))
    assert isinstance(found, Extent) and found.rate == pytest.approx(100) and found.duration == 2
    assert found.gate == pytest.approx(0.02 * found.top)


def test_saturation_marks_clipped_samples():
    t = np.linspace(0, 10, 1001)
    torque = np.column_stack([3 * np.sin(t), np.clip(3 * np.sin(t), -2, 2)])
    assert find_limit(torque[:, 0]) is None
    assert find_limit(torque[:, 1]) == 2.0
    noisy = torque + 0.05 * np.random.default_rng(0).standard_normal(torque.shape)
    assert find_limit(noisy[:, 0]) is None
    effect = LIBRARY["saturation"](1, limit=2.0)
    state = np.zeros((1001, 2))
    mask = saturated((effect, LIBRARY["viscous"](0)), Motion(t, state, state, state), torque)
    assert not mask[:, 0].any()
    at = np.abs(3 * np.sin(t)) >= 2 * (1 - 2e-3)
    beside = [at[max(i - 3, 0) : i + 4].any() for i in range(len(at))]  # three samples at each side
    np.testing.assert_array_equal(mask[:, 1], beside)
    assert effect.columns(Motion(t, state, state, state)).shape == (1001, 0)
