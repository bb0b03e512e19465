"""Every column against a closed form written out sample by sample: the slow twin of the library."""

from math import cos, exp, pi, sin, tanh

import numpy as np
import pytest
from effects.motions import RIGID, SCARA, STAGE, known, smooth

from chebid.effects import LIBRARY, Motion
from chebid.effects.dahl import bristle
from chebid.effects.transmission import JointFlexibility

MOTION = known(smooth(3, count=300))
EXACT = 1e-13  # rounding of a handful of operations, relative to columns of size 1 to 100


def sign(x):
    return float(x > 0) - float(x < 0)


def hard(x):
    return max(0.0, x)


# name, hyper-parameters, formula of (t, q, v, a, tau, q_other, v_other, a_other) per column, on joint 2
CLOSED = [
    ("viscous", {}, lambda t, q, v, a, tau, qo, vo, ao: [v]),
    ("coulomb", {}, lambda t, q, v, a, tau, qo, vo, ao: [sign(v)]),
    ("offset", {}, lambda t, q, v, a, tau, qo, vo, ao: [1.0]),
    ("viscous_asymmetry", {}, lambda t, q, v, a, tau, qo, vo, ao: [abs(v)]),
    ("stribeck", {"vs": 0.3}, lambda t, q, v, a, tau, qo, vo, ao: [exp(-((v / 0.3) ** 2)) * sign(v)]),
    ("stribeck", {"vs": 0.2, "delta": 1}, lambda t, q, v, a, tau, qo, vo, ao: [exp(-abs(v / 0.2)) * sign(v)]),
    ("viscous_quadratic", {}, lambda t, q, v, a, tau, qo, vo, ao: [v * abs(v)]),
    ("viscous_power", {"alpha": 0.4}, lambda t, q, v, a, tau, qo, vo, ao: [abs(v) ** 0.4 * sign(v)]),
    ("load_friction", {}, lambda t, q, v, a, tau, qo, vo, ao: [abs(tau) * sign(v)]),
    ("friction_ripple", {"k": 2.5}, lambda t, q, v, a, tau, qo, vo, ao: [sign(v) * f(2.5 * q) for f in (cos, sin)]),
    (
        "torque_ripple",
        {"k": 3.7, "harmonics": 2},
        lambda t, q, v, a, tau, qo, vo, ao: [f(n * 3.7 * q) for n in (1, 2) for f in (cos, sin)],
    ),
    ("spring", {}, lambda t, q, v, a, tau, qo, vo, ao: [q, -1.0]),
    ("spring", {"r": 0.6, "q0": 0.1}, lambda t, q, v, a, tau, qo, vo, ao: [0.6 * tanh((q - 0.1) / 0.6)]),
    ("spring", {"r": 0.6}, lambda t, q, v, a, tau, qo, vo, ao: [0.6 * tanh(q / 0.6)]),
    ("cubic_spring", {"q0": 0.2}, lambda t, q, v, a, tau, qo, vo, ao: [(q - 0.2) ** 3]),
    ("hard_stop", {"qs": 0.4, "m": 1.5}, lambda t, q, v, a, tau, qo, vo, ao: [hard(q - 0.4) ** 1.5]),
    ("hard_stop", {"qs": -0.3, "s": -1}, lambda t, q, v, a, tau, qo, vo, ao: [-hard(-0.3 - q)]),
    ("rotor_inertia", {}, lambda t, q, v, a, tau, qo, vo, ao: [a]),
    ("viscous_coupling", {"source": 0}, lambda t, q, v, a, tau, qo, vo, ao: [vo]),
    ("coulomb_coupling", {"source": 0}, lambda t, q, v, a, tau, qo, vo, ao: [sign(vo)]),
    (
        "motor_coupling",
        {"source": 0, "ratio": -2.0},
        lambda t, q, v, a, tau, qo, vo, ao: [-2 * ao, -2 * vo, sign(v - 2 * vo)],
    ),
    ("coulomb_drift", {"T": 7.0}, lambda t, q, v, a, tau, qo, vo, ao: [(1 - exp(-t / 7)) * sign(v)]),
    ("viscous_drift", {"T": 2.0}, lambda t, q, v, a, tau, qo, vo, ao: [(1 - exp(-t / 2)) * v]),
    ("torque_gain", {}, lambda t, q, v, a, tau, qo, vo, ao: [tau]),
    (
        "external_push",
        {"t0": 8.0, "width": 1.5},
        lambda t, q, v, a, tau, qo, vo, ao: [0.5 * (1 + cos(pi * (t - 8) / 1.5)) if abs(t - 8) < 1.5 else 0.0],
    ),
]


@pytest.mark.parametrize(("name", "hyper", "formula"), CLOSED, ids=[f"{c[0]}-{i}" for i, c in enumerate(CLOSED)])
def test_closed_form(name, hyper, formula):
    m = MOTION
    effect = LIBRARY[name](1, **hyper)
    states = zip(m.t, m.q[:, 1], m.dq[:, 1], m.ddq[:, 1], m.tau[:, 1], m.q[:, 0], m.dq[:, 0], m.ddq[:, 0], strict=True)
    wanted = np.array([formula(*state) for state in states])
    assert np.abs(effect.columns(m) - wanted).max() <= EXACT * max(1.0, np.abs(wanted).max())
    block = effect.block(m)
    np.testing.assert_array_equal(block[:, 1], effect.columns(m))
    if name != "motor_coupling":
        assert not block[:, 0].any()


def test_motor_coupling_acts_on_both_joints_as_a_motor_does():
    """By the principle of virtual work: inertia, drag and friction of a motor with speed w = dq2 + r dq1."""
    r, m = -2.0, MOTION
    block = LIBRARY["motor_coupling"](1, source=0, ratio=r).block(m)
    w, dw = m.dq[:, 1] + r * m.dq[:, 0], m.ddq[:, 1] + r * m.ddq[:, 0]
    motor = np.column_stack([dw, w, np.sign(w)])  # torque of the motor per unit
    own = np.zeros_like(block)  # what it does to each joint alone is not in the block
    own[:, 1, 0], own[:, 1, 1] = m.ddq[:, 1], m.dq[:, 1]
    own[:, 0, 0], own[:, 0, 1] = r**2 * m.ddq[:, 0], r**2 * m.dq[:, 0]
    np.testing.assert_allclose(block + own, motor[:, None, :] * np.array([r, 1.0])[None, :, None], atol=1e-12)


def test_torque_delay_is_the_derivative_of_the_models_torque():
    t = np.linspace(0, 10, 2001)
    state = np.zeros((2001, 2))
    tau = np.column_stack([np.sin(2 * t), np.cos(3 * t)])
    columns = LIBRARY["torque_delay"]().block(Motion(t, state, state, state, tau))[:, :, 0]
    wanted = np.column_stack([-2 * np.cos(2 * t), 3 * np.sin(3 * t)])
    # central differences: h^2 w^3 / 6 = 1.1e-4 inside, one-sided ends left out
    assert np.abs(columns - wanted)[1:-1].max() < 27 * 0.005**2 / 6 * 1.01


def test_torque_delay_over_a_time_is_exact_for_a_torque_that_is_that_late():
    t, late = np.arange(2001) / 200, 0.015  # three samples: nothing to interpolate
    state, rough = np.zeros((2001, 2)), np.random.default_rng(0).standard_normal((2001, 2))
    block = LIBRARY["torque_delay"](d=late).block(Motion(t, state, state, state, rough))[:, :, 0]
    np.testing.assert_allclose((rough + late * block)[3:], rough[:-3], atol=1e-9)  # rounding of t - d


def test_payload_on_a_scara_is_a_mass_on_its_second_link():
    """A point mass at (x, y) of link 2, by Lagrange's equations in the plane, from t0 on."""
    mass, length, x, y, m = 1.3, 0.4, 0.25, -0.1, smooth(5, count=200)
    block = LIBRARY["payload"](t0=10.0).bind(SCARA).block(m)
    values = mass * np.array([length**2, x**2 + y**2, length * x, length * y])
    c1, s1 = np.cos(m.q[:, 0]), np.sin(m.q[:, 0])
    c, s = np.cos(m.q.sum(axis=1)), np.sin(m.q.sum(axis=1))
    w, dw = m.dq.sum(axis=1), m.ddq.sum(axis=1)
    px, py = x * c - y * s, x * s + y * c  # from joint 2, in the base
    ax = length * (-s1 * m.ddq[:, 0] - c1 * m.dq[:, 0] ** 2) - py * dw - px * w**2
    ay = length * (c1 * m.ddq[:, 0] - s1 * m.dq[:, 0] ** 2) + px * dw - py * w**2
    second = mass * (px * ay - py * ax)
    first = mass * ((length * c1 + px) * ay - (length * s1 + py) * ax)
    wanted = np.column_stack([first, second]) * (m.t >= 10.0)[:, None]
    np.testing.assert_allclose(block @ values, wanted, atol=1e-12 * np.abs(wanted).max())


def test_base_tilt_on_a_scara_is_gravity_in_its_plane():
    gravity, weight1, weight2, m = np.array([0.3, -0.5]), 2.0, 0.7, smooth(6, count=100)  # weight: first moment, kg.m
    block = LIBRARY["base_tilt"]().bind(SCARA).block(m)
    both = m.q.sum(axis=1)
    along = np.column_stack([np.cos(m.q[:, 0]), np.sin(m.q[:, 0])]), np.column_stack([np.cos(both), np.sin(both)])
    moments = [
        -(w * (p[:, 0] * gravity[1] - p[:, 1] * gravity[0])) for w, p in zip((weight1, weight2), along, strict=True)
    ]
    wanted = np.column_stack([moments[0] + moments[1], moments[1]])
    values = np.concatenate([[-w * gravity[1], w * gravity[0]] for w in (weight1, weight2)])
    np.testing.assert_allclose(block @ values, wanted, atol=1e-13)


def test_base_tilt_on_axes_is_a_weight_or_a_pendulum():
    m = smooth(7, count=50)
    block = LIBRARY["base_tilt"]().bind(STAGE).block(m)
    zero = np.zeros(50)
    np.testing.assert_array_equal(block[:, 0], np.column_stack([np.ones(50), zero, zero]))
    np.testing.assert_array_equal(block[:, 1], np.column_stack([zero, np.cos(m.q[:, 1]), np.sin(m.q[:, 1])]))


def test_payload_on_axes_is_more_inertia():
    m = smooth(7, count=50)
    block = LIBRARY["payload"]().bind(STAGE).block(m)
    np.testing.assert_array_equal(block, m.ddq[:, :, None] * np.eye(2))


# presliding -----------------------------------------------------------------------------------------------------------


def test_bristle_sample_by_sample():
    q = smooth(8, count=500).q[:, 0]
    z = [0.0]
    for step in np.diff(q):
        s = sign(step)
        z.append(s - (s - z[-1]) * exp(-abs(step) / 0.03) if s else z[-1])
    np.testing.assert_allclose(bristle(q, 0.03), z, atol=1e-12)


def test_bristle_is_the_solution_of_dahls_equation():
    """Against a fine Runge-Kutta integration in time of dz/dt = (dq - z abs(dq))/delta."""
    delta, t = 0.05, np.linspace(0, 6, 60001)
    rate = lambda x, z: (np.cos(x) - z * abs(np.cos(x))) / delta  # noqa: E731 - q = sin t
    z, h = np.zeros(len(t)), t[1]
    for i, x in enumerate(t[:-1]):
        k1 = rate(x, z[i])
        k2 = rate(x + h / 2, z[i] + h / 2 * k1)
        k3 = rate(x + h / 2, z[i] + h / 2 * k2)
        z[i + 1] = z[i] + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h, z[i] + h * k3))
    coarse = slice(None, None, 100)  # 601 samples; a reversal falls between two of them
    assert np.abs(bristle(np.sin(t[coarse]), delta) - z[coarse]).max() < 2e-3


def test_bristle_at_rest_keeps_its_bend():
    assert bristle(np.zeros(5), 0.1, 0.3).tolist() == [0.3] * 5
    q = np.array([0.0, 0.1, 0.1, 0.1, 0.2])
    z = bristle(q, 0.1)
    assert z[1] == z[2] == z[3] and z[4] == pytest.approx(1 - exp(-2), rel=1e-14)
    assert bristle(np.array([0.4]), 0.1).tolist() == [0.0]


def test_presliding_vanishes_far_from_reversals_and_is_two_just_after():
    t = np.linspace(0, 1, 2001)
    q = np.abs(t - 0.5)[:, None]
    dq = np.sign(t - 0.5)[:, None]
    column = LIBRARY["presliding"](0, delta=0.01).columns(Motion(t, q, dq, 0 * q))[:, 0]
    assert abs(column[999]) < 1e-20 and abs(column[-1]) < 1e-20
    assert column[1001] == pytest.approx(-2 * exp(-0.05), rel=1e-9)


# elastic joints -------------------------------------------------------------------------------------------------------


def elastic(compliance: float, joint: int) -> float:
    """Relative error of the signature against a link that really lags its motor by compliance x its torque."""
    link = smooth(9, count=8001, duration=8.0, size=0.3)
    load = SCARA.regressor(link.q, link.dq, link.ddq) @ RIGID
    ahead = compliance * load * np.eye(2)[joint]
    rate = np.gradient(ahead, link.t, axis=0)
    state = link.q + ahead, link.dq + rate, link.ddq + np.gradient(rate, link.t, axis=0)
    seen = Motion(link.t, *state).with_model(load, RIGID)
    column = JointFlexibility(joint).bind(SCARA).block(seen)[:, :, 0]
    missing = load - SCARA.regressor(seen.q, seen.dq, seen.ddq) @ RIGID
    inner = slice(50, -50)  # differences at the ends are worse
    return float(np.linalg.norm((missing - compliance * column)[inner]) / np.linalg.norm(missing[inner]))


@pytest.mark.parametrize("joint", [0, 1])
def test_flexibility_is_the_first_order_of_a_lagging_link(joint):
    """The relative error is of the order of the compliance: it falls with it."""
    size = [1e-4, 1e-2][joint]  # rad/(N.m): some 50 rad/s of resonance either way
    coarse, fine = elastic(size, joint), elastic(size / 8, joint)
    assert coarse < 0.15
    assert fine < 0.2 * coarse


def test_backlash_is_a_lag_of_half_the_gap():
    """Far from a change of side the lag is constant, so that only its place matters: none on a SCARA's first joint."""
    t = np.linspace(0, 1, 201)
    ddq = np.column_stack([np.full(201, 2.0), np.zeros(201)])
    m = Motion(t, np.zeros((201, 2)), np.zeros((201, 2)), ddq).with_model(np.ones((201, 2)), RIGID)
    # rounding of a torque of 7 N.m, over the small distance of the derivative
    assert np.abs(LIBRARY["backlash"](0, soft=1e-3).bind(SCARA).block(m)).max() < 7 * 2**-52 / 1e-4 * 2
    assert LIBRARY["backlash"](1, soft=1e-3).slack(np.array([-5.0, 5.0])).tolist() == [-0.5, 0.5]
