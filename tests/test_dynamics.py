"""A robot with its effects as one regressor: names, places, the model's own torque, and what depends on what."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from effects.motions import RIGID, SCARA, STAGE, all_of, known, smooth
from hypothesis import given, settings
from hypothesis import strategies as st

from chebid.dynamics import Dynamics, make_dynamics, settle
from chebid.effects import LIBRARY, Motion
from chebid.effects.dependence import dependent_columns
from chebid.effects.trial import trial_motion, trial_values
from chebid.errors import InputError, UsageError
from chebid.model import Model
from chebid.robots import Axes, Parameter

MOTION = smooth(31, count=1500)


def model(*effects, robot=None, joints=("q1", "q2"), **more):
    robot = robot or {"type": "scara"}
    return Model.model_validate({"robot": robot, "joints": joints, "effects": list(effects), **more})


def fit(motion, torque):
    """Plain least squares, for `settle`."""

    def solve(dynamics):
        W = dynamics.regressor(motion).reshape(-1, len(dynamics.parameters))
        return np.linalg.lstsq(W, torque.reshape(-1))[0]

    return solve


# names and places -----------------------------------------------------------------------------------------------------


def test_the_papers_order():
    """Eq. 19: joint by joint, the rigid body first."""
    dynamics = make_dynamics(
        model("viscous", "coulomb", "torque_delay", {"effect": "stribeck", "joint": "q1", "vs": 0.1})
    )
    names = [p.name for p in dynamics.parameters]
    assert names == ["ZZR1", "Fv1", "Fs1", "Fst1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2", "delay"]
    assert [p.joint for p in dynamics.parameters] == ["q1"] * 4 + ["q2"] * 5 + [None]


def test_reference_torques_of_the_paper():
    """facts.md, section 3: eq. 18 corrected, at one state."""
    motion = Motion(*(np.array([x]) for x in (0.0, [0.3, -0.7], [1.2, -0.4], [-2.0, 3.0])))
    dynamics = make_dynamics(model("viscous", "coulomb"))
    theta = np.array([3.45, 0.03, 0.8, 0.061, 0.124, 0.008, 0.012, 0.13])
    np.testing.assert_allclose(dynamics.torque(motion, theta)[0], [-6.16200558, -0.38000887], atol=5e-9)


def test_two_of_a_kind_have_different_names():
    ripples = [{"effect": "torque_ripple", "joint": "q1", "k": k} for k in (3, 5, 8)]
    dynamics = make_dynamics(model(*ripples))
    assert [p.name for p in dynamics.parameters][1:7] == ["bc1", "bs1", "bc1.2", "bs1.2", "bc1.3", "bs1.3"]
    assert dynamics.names(dynamics.effects[1]) == ("bc1.2", "bs1.2")
    assert dynamics.hyperparameters() == {
        "torque_ripple:q1": {"k": 3.0, "harmonics": 1},
        "torque_ripple:q1.2": {"k": 5.0, "harmonics": 1},
        "torque_ripple:q1.3": {"k": 8.0, "harmonics": 1},
    }


def test_hyperparameters_name_joints():
    dynamics = make_dynamics(model({"effect": "coulomb_coupling", "joint": "q1"}, {"effect": "payload", "t0": 3}))
    assert dynamics.hyperparameters() == {"coulomb_coupling:q1": {"source": "q2"}, "payload": {"t0": 3.0}}


@settings(max_examples=20)
@given(st.randoms(use_true_random=False))
def test_columns_follow_their_names(random):
    """The order of the entries changes the places, never what a name means."""
    effects = [e for e in all_of(known(MOTION)) if not e.needs_model][::3]
    effects = list({(e.name, e.joint): e for e in effects}.values())
    shuffled = random.sample(effects, len(effects))
    one, other = Dynamics(SCARA, tuple(effects)), Dynamics(SCARA, tuple(shuffled))
    piece = MOTION.cut(slice(0, 40))
    by_name = [
        {p.name: column for p, column in zip(d.parameters, np.moveaxis(d.regressor(piece), 2, 0), strict=True)}
        for d in (one, other)
    ]
    assert by_name[0].keys() == by_name[1].keys()
    for name, column in by_name[0].items():
        np.testing.assert_array_equal(column, by_name[1][name])


def test_values_by_effect():
    dynamics = make_dynamics(model("viscous", "spring"))
    theta = np.arange(1.0, len(dynamics.parameters) + 1)
    values = dynamics.named(theta)
    found = {(e.name, e.joint): p.tolist() for e, p in dynamics.terms(theta)}
    assert found["spring", 1] == [values["k2"], values["kq02"]]
    assert dynamics.rigid(theta).tolist() == [values[p.name] for p in SCARA.parameters]
    assert {d.name: d.value for d in dynamics.derived(theta)} == {
        "q0_1": values["kq01"] / values["k1"],
        "q0_2": values["kq02"] / values["k2"],
    }


def test_signs_for_the_gate():
    dynamics = make_dynamics(model("viscous", "coulomb", {"effect": "coulomb_coupling", "joint": "q1"}))
    assert dynamics.signs(0) == (0, 1) and dynamics.signs(1) == (1,)


def test_saturated_samples():
    dynamics = make_dynamics(model("viscous", {"effect": "saturation", "joint": "q2", "limit": 1.0}))
    torque = np.full((len(MOTION), 2), 1.0)
    assert dynamics.unusable(MOTION, torque).all(axis=0).tolist() == [False, True]
    assert [p.name for p in dynamics.parameters][-1] == "Fv2"


# the model's own torque -----------------------------------------------------------------------------------------------

LOADED = [
    (["viscous", "coulomb", "load_friction"], {"mu": 0.08}),
    (["viscous", "coulomb", "torque_delay"], {"delay": 0.004}),
    (["viscous", "coulomb", {"effect": "torque_gain", "joint": "q2"}], {"g": 0.05}),
    (["viscous", {"effect": "joint_flexibility", "joint": "q2"}], {"C": 2e-3}),
    ([{"effect": "mine", "joint": "q1", "formula": "abs(tau_model)*sign(dq)", "symbol": "mine"}], {"mine": 0.08}),
]


@pytest.mark.parametrize(("effects", "values"), LOADED, ids=range(len(LOADED)))
def test_settle_finds_the_parameters_of_exact_torques(effects, values):
    dynamics = make_dynamics(model(*effects))
    theta = np.array(
        [
            0.1 if p.name[0] == "F" else next((v for s, v in values.items() if p.name.startswith(s)), 0)
            for p in dynamics.parameters
        ]
    )
    theta[[i for i, p in enumerate(dynamics.parameters) if p in SCARA.parameters]] = RIGID
    solve = fit(MOTION, dynamics.torque(MOTION, theta))
    settled = settle(dynamics, solve)
    found = settled.named(solve(settled))
    for name, value in dynamics.named(theta).items():
        # settled to 1e-9 of the largest parameter, 3.45
        assert found[name] == pytest.approx(value, abs=2e-8), name


def test_settle_leaves_others_alone():
    dynamics = make_dynamics(model("viscous"))
    assert settle(dynamics, lambda d: pytest.fail("fitted")) is dynamics


def test_own_torque_is_that_of_the_effects_which_need_none():
    dynamics = make_dynamics(model("viscous", "load_friction"))
    theta = np.random.default_rng(1).uniform(0.5, 1.5, len(dynamics.parameters))
    values = dynamics.named(theta)
    base = dynamics.base
    assert {p.name for p in dynamics.parameters} - {p.name for p in base.parameters} == {"mu1", "mu2"}
    tau = base.torque(MOTION, np.array([values[p.name] for p in base.parameters]))
    mu = np.array([values["mu1"], values["mu2"]])
    np.testing.assert_allclose(dynamics.torque(MOTION, theta), tau + mu * np.abs(tau) * np.sign(MOTION.dq), atol=1e-12)
    np.testing.assert_allclose(dynamics.at(theta).regressor(MOTION) @ theta, dynamics.torque(MOTION, theta), atol=1e-12)


def test_own_torque_unknown():
    dynamics = make_dynamics(model("viscous", "load_friction"))
    with pytest.raises(UsageError, match="load_friction: made of the model's own torque"):
        dynamics.regressor(MOTION)
    handed = Motion(MOTION.t, MOTION.q, MOTION.dq, MOTION.ddq, tau=np.ones((len(MOTION), 2)))
    np.testing.assert_array_equal(dynamics.regressor(handed)[:, 0, 2], np.sign(MOTION.dq[:, 0]))


def test_measured_torque_is_never_asked_for():
    """The columns depend on the motion and the model alone: no argument could carry a measurement."""
    dynamics = make_dynamics(model("viscous", "load_friction"))
    first = dynamics.at({"ZZR1": 1.0}).regressor(MOTION)
    assert np.abs(first[:, 0, 2]) == pytest.approx(np.abs(MOTION.ddq[:, 0]))


@settings(max_examples=10)
@given(st.lists(st.integers(1, 1499), max_size=4, unique=True))
def test_pieces_give_the_same_regressor(cuts):
    """Whatever the pieces, also for effects that remember or look at the model's torque."""
    effects = ["viscous", {"effect": "presliding", "joint": "q1", "delta": 0.05}, "torque_delay", "load_friction"]
    effects += [{"effect": "coulomb_drift", "joint": "q2", "T": 5}, {"effect": "joint_flexibility", "joint": "q2"}]
    dynamics = make_dynamics(model(*effects))
    dynamics = dynamics.at(trial_values(len(dynamics.parameters)))
    edges = [0, *sorted(cuts), len(MOTION)]
    parts = [dynamics.regressor(MOTION.cut(slice(a, b))) for a, b in pairwise(edges)]
    whole = dynamics.regressor(MOTION)
    np.testing.assert_allclose(np.concatenate(parts), whole, atol=1e-12 * np.abs(whole).max())


def test_long_motions_in_chunks():
    """The torque of 70 000 samples is the regressor of all at once times theta."""
    motion = smooth(1, count=70_000, duration=70)
    dynamics = make_dynamics(model("viscous", {"effect": "presliding", "joint": "q1", "delta": 0.01}))
    theta = trial_values(len(dynamics.parameters))
    np.testing.assert_allclose(dynamics.torque(motion, theta), dynamics.regressor(motion) @ theta, atol=1e-12)


def test_a_candidate_need_not_be_in_the_model():
    dynamics = make_dynamics(model("viscous", "coulomb"))
    dynamics = dynamics.at(trial_values(len(dynamics.parameters)))
    block = dynamics.block(LIBRARY["load_friction"](1), MOTION)
    tau = dynamics.torque(MOTION, trial_values(len(dynamics.parameters)))
    np.testing.assert_allclose(block[:, 1, 0], np.abs(tau[:, 1]) * np.sign(MOTION.dq[:, 1]))
    assert not block[:, 0].any()
    assert dynamics.block(LIBRARY["payload"](), MOTION).shape == (len(MOTION), 2, 4)


# what depends on what -------------------------------------------------------------------------------------------------

STAGE_ROBOT = {"type": "axes", "types": ["prismatic"]}


def test_rotor_of_the_first_joint_is_part_of_its_inertia():
    dynamics = make_dynamics(model("viscous", "rotor_inertia"))
    assert [p.name for p in dynamics.parameters] == ["ZZR1", "Fv1", "ZZ2", "LMX2", "LMY2", "Fv2", "Ia2"]
    (notice,) = dynamics.notices
    assert notice.kind == "dependent" and "Ia1 is left out" in str(notice) and "ZZR1" in str(notice)


def test_a_spring_beside_an_offset_keeps_its_stiffness_only():
    dynamics = make_dynamics(model("offset", {"effect": "spring", "joint": "q1"}))
    assert dynamics.dropped == {"kq01"} and "k1" in [p.name for p in dynamics.parameters]
    (spring,) = [p for e, p in dynamics.terms(np.ones(len(dynamics.parameters))) if e.name == "spring"]
    assert spring.tolist() == [1.0, 0.0]


@pytest.mark.parametrize(
    ("entry", "robot", "joints", "others"),
    [
        ({"effect": "rotor_inertia", "joint": "q1"}, None, ("q1", "q2"), "ZZR1"),
        ({"effect": "torque_gain", "joint": "x"}, STAGE_ROBOT, ("x",), "Fv1, M1"),
        ("payload", None, ("q1", "q2"), "LMX2, LMY2, ZZ2, ZZR1"),
        ("base_tilt", STAGE_ROBOT | {"types": ["prismatic"]}, ("x",), None),
    ],
)
def test_an_entry_that_says_nothing_new_is_refused(entry, robot, joints, others):
    extra = ["viscous", entry] if others else ["offset", entry]
    with pytest.raises(InputError, match=f"cannot be told from {others or 'Foff1'} on any motion") as caught:
        make_dynamics(model(*extra, robot=robot, joints=joints))
    assert caught.value.place.key == "effects.1"


def test_gain_of_both_joints_is_one_too_many():
    dynamics = make_dynamics(model("torque_gain", "viscous"))
    assert dynamics.dropped == {"g2"} and [e.joint for e in dynamics.effects if e.name == "torque_gain"] == [0]


def test_an_effect_without_columns_left_needs_no_torque():
    dynamics = make_dynamics(model("viscous", "torque_gain", robot=STAGE_ROBOT, joints=("x",)))
    assert not dynamics.needs_model and dynamics.regressor(smooth(1, count=10, joints=1)).shape == (10, 1, 2)


def test_values_in_a_fitted_model_keep_what_cannot_be_identified():
    """A payload from the start cannot be found beside free parameters, but it can act where theirs are held."""
    values = {"ZZR1": 3.45, "ZZ2": 0.061, "LMX2": 0.124, "LMY2": 0.008}
    payload = {"dZZR1": 0.2, "dZZ2": 0.01, "dLMX2": 0.02, "dLMY2": 0.0}
    parameters = {name: {"value": value, "unit": "kg.m^2"} for name, value in (values | payload).items()}
    fitted = model("payload", fit={"method": "poly", "parameters": parameters})
    dynamics = make_dynamics(fitted)
    theta = np.array([(values | payload)[p.name] for p in dynamics.parameters])
    sums = np.array(list(values.values())) + np.array(list(payload.values()))
    wanted = SCARA.regressor(MOTION.q, MOTION.dq, MOTION.ddq) @ sums
    np.testing.assert_allclose(dynamics.torque(MOTION, theta), wanted, atol=1e-12)


def test_a_fitted_model_leaves_out_what_its_fit_left_out():
    parameters = {n: {"value": 1.0} for n in ("ZZR1", "ZZ2", "LMX2", "LMY2", "Ia2")}
    dynamics = make_dynamics(model("rotor_inertia", fit={"method": "poly", "parameters": parameters}))
    assert {p.name for p in dynamics.parameters} == set(parameters) and not dynamics.notices
    assert dynamics.reference == {name: 1.0 for name in parameters}


def test_what_a_motion_does_not_show_is_not_called_dependent():
    """A stop beyond the range of the trial motion has a column of zeros there."""
    dynamics = make_dynamics(model({"effect": "hard_stop", "joint": "q1", "qs": 50.0}))
    assert "kh1" in [p.name for p in dynamics.parameters]


@pytest.mark.parametrize("robot", [SCARA, STAGE], ids=["scara", "axes"])
def test_no_effect_alone_depends_on_the_rigid_body_but_those_known(robot):
    """Each effect beside friction: what depends is known and explained."""
    friction = tuple(LIBRARY[name](j) for name in ("viscous", "coulomb") for j in (0, 1))
    found = set()
    for effect in all_of(known(trial_motion(2), robot), robot):
        if effect.name in ("viscous", "coulomb"):
            continue
        dependent = Dynamics(robot, (*friction, effect)).dependent()
        found |= {(effect.name, effect.joint, tuple(effect.hyper.values())[:1], len(dependent))} if dependent else set()
    rotor = {("rotor_inertia", 0, (), 1)} | ({("rotor_inertia", 1, (), 1)} if robot is STAGE else set())
    load = {("payload", None, (None,), len(robot.parameters))}
    gain = {("torque_gain", j, (), 1) for j in (0, 1)} if robot is STAGE else set()
    assert found == rotor | load | gain


@given(st.integers(0, 10**6))
def test_dependent_columns(seed):
    rng = np.random.default_rng(seed)
    X = rng.normal(size=(30, 4)) * 10.0 ** rng.integers(-6, 6, 4)
    mixed = X[:, 0] * 3 - X[:, 2] / np.linalg.norm(X[:, 2]) * np.linalg.norm(X[:, 0])
    columns = np.column_stack([X, mixed, np.zeros(30), rng.normal(size=30)])
    assert dependent_columns(columns, 2) == {4: [0, 2]}
    assert dependent_columns(columns[:, :4], 0) == {}


def test_a_robot_with_more_to_say():
    """A pendulum that knows gravity and loads: payload and tilt take what it offers."""

    class Pendulum(Axes):
        gravity = (0.0, -9.81, 0.0)
        load_parameters = (Parameter("m", None, "kg"),)

        def load_regressor(self, q, dq, ddq):
            return ddq[:, :, None]

        def lean(self, q, rigid):
            return rigid[0] * np.stack([-np.sin(q), np.cos(q), 0 * q], axis=2)

    robot = Pendulum(("a",), ("revolute",))
    dynamics = Dynamics(robot, (LIBRARY["payload"](t0=1.0), LIBRARY["base_tilt"]()))
    assert [(p.name, p.unit) for p in dynamics.parameters] == [
        ("J1", "kg.m^2"), ("m_load", "kg"), ("dgx", "m/s^2"), ("dgy", "m/s^2"), ("dgz", "m/s^2")
    ]  # fmt: skip
    motion = smooth(1, count=20, joints=1)
    theta = np.array([2.0, 0.5, 9.81 * np.sin(0.1), 9.81 * (1 - np.cos(0.1)), 0.0])
    q = motion.q[:, 0]
    wanted = (2 + 0.5 * (motion.t >= 1)) * motion.ddq[:, 0] + 2 * (theta[3] * np.cos(q) - theta[2] * np.sin(q))
    np.testing.assert_allclose(dynamics.torque(motion, theta)[:, 0], wanted, atol=1e-12)
    derived = {d.name: d.value for d in dynamics.derived(theta)}
    assert derived["tilt"] == pytest.approx(0.1, rel=1e-12)
    assert replace(dynamics, effects=()).derived(theta[:1]) == ()
