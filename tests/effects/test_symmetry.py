"""What nature demands of each effect: friction turns round with the motion, springs do not, and so on."""

import numpy as np
import pytest
from effects.motions import RIGID, SCARA, all_of, known, label, smooth
from hypothesis import given, settings
from hypothesis import strategies as st

from chebid.dynamics import Dynamics
from chebid.effects import LIBRARY, Motion

MOTION = known(smooth(11, count=300))
EFFECTS = all_of(MOTION)
# what happens to the columns when every velocity changes its sign at the same places and accelerations
ODD = {"viscous", "coulomb", "stribeck", "viscous_quadratic", "viscous_power", "load_friction", "friction_ripple"}
ODD |= {"viscous_coupling", "coulomb_coupling", "coulomb_drift", "viscous_drift"}
EVEN = {
    "offset",
    "viscous_asymmetry",
    "torque_ripple",
    "spring",
    "cubic_spring",
    "hard_stop",
    "rotor_inertia",
    "payload",
}
EVEN |= {"base_tilt", "external_push", "torque_gain"}
NEITHER = {"presliding", "motor_coupling", "torque_delay", "joint_flexibility", "backlash", "saturation"}


def test_every_effect_is_one_of_them():
    assert set(LIBRARY) == ODD | EVEN | NEITHER and not (ODD & EVEN)


@pytest.mark.parametrize("effect", EFFECTS, ids=label)
def test_odd_or_even_in_velocity(effect):
    m = MOTION
    back = Motion(m.t, m.q, -m.dq, m.ddq, m.tau, m.rigid)
    if effect.name in ODD:
        np.testing.assert_array_equal(effect.block(back), -effect.block(m))
    elif effect.name in EVEN:
        np.testing.assert_array_equal(effect.block(back), effect.block(m))


@pytest.mark.parametrize("effect", EFFECTS, ids=label)
def test_only_its_own_rows(effect):
    block = effect.block(MOTION)
    others = [j for j in range(2) if j not in effect.rows(2)]
    assert not block[:, others].any()
    assert block.shape == (300, 2, len(effect.symbols))
    np.testing.assert_array_equal(effect.on(MOTION), block[:, list(effect.rows(2))])


@pytest.mark.parametrize("effect", [e for e in EFFECTS if not e.memory], ids=label)
def test_without_memory_samples_do_not_know_each_other(effect):
    order = np.random.default_rng(0).permutation(300)
    m = MOTION
    mixed = Motion(m.t[order], m.q[order], m.dq[order], m.ddq[order], m.tau[order], m.rigid)
    if effect.name.endswith("_drift"):  # counts from the first instant, by design
        order, mixed = np.arange(300), m.cut(slice(0, 300))
    # cos and sin of an array may differ in the last digit with the place in it
    np.testing.assert_allclose(effect.block(mixed), effect.block(m)[order], rtol=0, atol=1e-14 * 100)


@pytest.mark.parametrize("effect", EFFECTS, ids=label)
@settings(max_examples=5)
@given(cut=st.tuples(st.integers(0, 140), st.integers(160, 300)))
def test_pieces_are_parts_of_the_whole(effect, cut):
    """Also for effects that remember: a piece of a motion knows what went before."""
    piece = slice(*cut)
    np.testing.assert_allclose(effect.on(MOTION.cut(piece)), effect.on(MOTION)[piece], rtol=0, atol=1e-14 * 100)


def test_cuts_of_cuts():
    twice = MOTION.cut(slice(50, 200)).cut(slice(10, 60))
    np.testing.assert_array_equal(twice.q, MOTION.q[60:110])
    assert twice.whole is MOTION and twice.piece == slice(60, 110) and twice.start == MOTION.t[0]


@pytest.mark.parametrize("effect", [e for e in EFFECTS if e.signs], ids=label)
def test_signs_name_the_joints_whose_direction_matters(effect):
    """The sign of the velocity of any other joint changes nothing."""
    m = MOTION
    for joint in range(2):
        dq = m.dq.copy()
        dq[:, joint] *= -1
        same = np.allclose(effect.block(Motion(m.t, m.q, dq, m.ddq, m.tau, m.rigid)), effect.block(m), atol=1e-12)
        assert same == (joint not in effect.signs)


@pytest.mark.parametrize(
    "name", ["viscous", "coulomb", "viscous_quadratic", "viscous_power", "load_friction", "stribeck"]
)
def test_friction_takes_energy(name):
    for effect in EFFECTS:
        if effect.name == name:
            assert (effect.columns(MOTION)[:, 0] * MOTION.dq[:, effect.joint]).min() >= 0


def test_stops_push_back_and_only_beyond_them():
    q = np.linspace(-1, 1, 201)[:, None]
    m = Motion(q[:, 0], q, 0 * q, 0 * q)
    upper, lower = (LIBRARY["hard_stop"](0, qs=0.5 * s, s=s).columns(m)[:, 0] for s in (1, -1))
    assert not upper[q[:, 0] <= 0.5].any() and (upper[q[:, 0] > 0.5] > 0).all()
    np.testing.assert_allclose(lower, -upper[::-1], atol=1e-15)


def test_drift_begins_at_the_start_of_the_record_whatever_its_clock():
    m = MOTION
    late = Motion(m.t + 1e9, m.q, m.dq, m.ddq)
    drift = LIBRARY["viscous_drift"](0, T=4.0)
    np.testing.assert_allclose(drift.columns(late), drift.columns(m), atol=1e-6)  # 1e9 s leaves 1e-7 s
    assert drift.columns(m)[0] == 0
    np.testing.assert_array_equal(drift.on(m.cut(slice(100, 120))), drift.on(m)[100:120])


@given(values=st.lists(st.floats(-5, 5), min_size=2, max_size=2), rest=st.floats(-3, 3))
def test_spring_rest_position(values, rest):
    spring, k = LIBRARY["spring"](1), values[0]
    found = spring.derived([k, k * rest], (True, True))
    if k:
        assert found[0].value == pytest.approx(rest, abs=1e-12 * (1 + abs(rest))) or abs(k * rest) < 1e-300
        assert (found[0].name, found[0].unit) == ("q0_2", "rad")
    else:
        assert found == ()


@given(rest=st.floats(-1, 1), r=st.floats(0.1, 10))
def test_a_softening_spring_is_linear_near_its_rest_and_nowhere_stiffer(rest, r):
    linear, soft = LIBRARY["spring"](0), LIBRARY["spring"](0, r=r, q0=rest)
    q = rest + r * np.array([-3.0, -0.5, -1e-4, 0.0, 1e-4, 0.5, 3.0])[:, None]
    m = Motion(q[:, 0], q, 0 * q, 0 * q)
    hard, pull = linear.columns(m) @ [2.0, 2.0 * rest], soft.columns(m) @ [2.0]
    np.testing.assert_allclose(pull[2:5], hard[2:5], atol=1e-8 * r)  # the next term is the cube of 1e-4
    assert (np.abs(pull[[0, 1, 5, 6]]) < np.abs(hard[[0, 1, 5, 6]])).all()
    assert (pull * (q[:, 0] - rest) >= 0).all()


def test_stiffness_of_a_joint():
    found = LIBRARY["joint_flexibility"](0).derived([2e-4], (True, True))
    assert (found[0].name, found[0].value, found[0].unit) == ("K1", 5000.0, "N.m/rad")


def test_a_model_with_every_effect_predicts_the_sum_of_its_parts():
    effects = tuple({(e.name, e.joint): e for e in EFFECTS}.values())
    dynamics = Dynamics(SCARA, effects)
    theta = np.random.default_rng(5).uniform(-1, 1, len(dynamics.parameters))
    rigid = dynamics.rigid(theta)
    m = dynamics.prepare(smooth(11, count=300), theta)
    parts = sum((effect.block(m) @ p for effect, p in dynamics.terms(theta)), SCARA.regressor(m.q, m.dq, m.ddq) @ rigid)
    np.testing.assert_allclose(dynamics.torque(smooth(11, count=300), theta), parts, atol=1e-9 * np.abs(parts).max())
    assert len(RIGID) == len(rigid)
