"""A link that hangs on its motor: against the closed form of a spring, and told apart on arms integrated elsewhere."""

import numpy as np
import pytest
from arms import make_log, make_model
from critique.hidden import KINDS
from scipy.integrate import solve_ivp

from chebid.critique import Case, diagnose
from chebid.critique.transmission import Hang, _lag, _springs
from chebid.estimators import Problem, estimate

STAGE = {"robot": {"type": "axes", "types": ["prismatic"]}, "joints": ["x"], "effects": ["viscous", "coulomb"]}
MASS, VISCOUS, COULOMB = 20.0, 30.0, 5.0  # kg, N.s/m, N
WAVES = np.array([[0.11, 0.21, 0.4], [0.37, 0.13, 1.9], [0.83, 0.06, 3.1], [1.7, 0.02, 0.8], [2.9, 0.008, 5.0]])


OTHER = np.array([[0.17, 0.16, 1.1], [0.29, 0.17, 2.4], [0.71, 0.05, 0.2], [1.9, 0.018, 3.8], [3.3, 0.006, 1.0]])


def motor(t, waves=WAVES):
    """Position, velocity and acceleration of the motor: five sines of (Hz, m, rad)."""
    w, size, phase = 2 * np.pi * waves[:, 0], waves[:, 1], waves[:, 2]
    angle = np.multiply.outer(np.asarray(t), w) + phase
    return (size * np.sin(angle)).sum(-1), (size * w * np.cos(angle)).sum(-1), (-size * w**2 * np.sin(angle)).sum(-1)


def hung_log(stiffness: float, damping: float, gap: float, seed: int = 0, noise: float = 1.0, waves=WAVES):
    """Motor positions and forces of a mass that hangs on its motor, integrated by scipy."""
    t = np.arange(2001) / 100

    def force(time, x, speed):
        q, dq, _ = motor(time, waves)
        lag = q - x
        beyond = lag - np.clip(lag, -gap / 2, gap / 2)
        return np.where(beyond != 0, stiffness * beyond + damping * (dq - speed), 0.0)

    q, dq, ddq = motor(t, waves)
    start = MASS * ddq[0] / stiffness + np.sign(ddq[0]) * gap / 2  # wound up, so that nothing rings
    done = solve_ivp(
        lambda time, s: [s[1], float(force(time, s[0], s[1])) / MASS],
        (0.0, t[-1]),
        [q[0] - start, dq[0]],
        t_eval=t,
        max_step=1e-3,
        rtol=1e-6,
        atol=1e-9,
    )
    tau = force(t, done.y[0], done.y[1]) + VISCOUS * dq + COULOMB * np.sign(dq)
    rng = np.random.default_rng(seed)
    return make_log(
        t, np.round(q[:, None] / 1e-6) * 1e-6, tau[:, None] + noise * rng.standard_normal((len(t), 1)), ["x"]
    )


def best_of(log):
    problem = Problem(make_model(STAGE), (log,))
    return diagnose(Case(problem, estimate(problem, "poly").theta), KINDS)


@pytest.mark.parametrize("frequency", [4.0, 12.0, 30.0])
def test_a_spring_answers_a_sine_as_the_closed_form_says(frequency):
    """Gain and phase of K + D s over M s^2 + D s + K, after the start has died away; 1 % for steps of 1 ms at 30 Hz."""
    t, mass, wave = np.arange(4001) / 200, 2.0, 2 * np.pi * 1.3
    hang = Hang(np.array([frequency]), np.zeros(1))
    torque, _ = _lag(t, np.full(len(t), mass), np.sin(wave * t), hang)
    w = 2 * np.pi * frequency
    K, D = mass * w**2, 2 * hang.damping[0] * w * mass
    s = 1j * wave
    gain = (K + D * s) / (mass * s**2 + D * s + K)
    late = t > 15
    expected = np.abs(gain) * np.sin(wave * t + np.angle(gain))
    np.testing.assert_allclose(torque[late, 0], expected[late], atol=0.01 * np.abs(gain))


def test_a_gap_passes_no_torque_while_it_is_open():
    """A torque that changes sign once: the link is free until it has crossed the gap, for sqrt(2 gap M / tau)."""
    t, mass, gap = np.arange(2001) / 1000, 2.0, 0.01
    tau = np.where(t < 1.0, 1.0, -1.0)
    torque, _ = _lag(t, np.full(len(t), mass), tau, Hang(np.array([60.0]), np.array([gap])))
    free = (t > 1.0) & (torque[:, 0] == 0)
    settled = t[free & (t < 1.6)]
    assert np.ptp(settled) >= 0.9 * np.sqrt(2 * gap * mass)


def test_a_spring_is_named_and_not_a_gap():
    d = best_of(hung_log(stiffness=MASS * (2 * np.pi * 9.0) ** 2, damping=100.0, gap=0.0))
    assert d.verdict.status == "missing"
    assert d.verdict.best.effect.name == "joint_flexibility"
    assert "backlash" not in {one.effect.name for one in d.verdict.alternatives}


def test_a_gap_is_named_and_not_a_spring():
    d = best_of(hung_log(stiffness=MASS * (2 * np.pi * 80.0) ** 2, damping=16000.0, gap=6e-3))
    assert d.verdict.status == "missing"
    assert d.verdict.best.effect.name == "backlash"
    assert "joint_flexibility" not in {one.effect.name for one in d.verdict.alternatives}


@pytest.mark.parametrize(
    ("name", "hung"),
    [
        ("joint_flexibility", {"stiffness": MASS * (2 * np.pi * 9.0) ** 2, "damping": 100.0, "gap": 0.0}),
        ("backlash", {"stiffness": MASS * (2 * np.pi * 80.0) ** 2, "damping": 16000.0, "gap": 6e-3}),
    ],
)
def test_what_was_simulated_predicts_another_motion(name, hung):
    """Its parameter is that of the arm: on the hold-out it is simulated again, with what was found."""
    problem = Problem(make_model(STAGE), (hung_log(**hung),))
    case = Case(
        problem,
        estimate(problem, "poly").theta,
        holdout=Problem(problem.model, (hung_log(**hung, seed=1, waves=OTHER),)),
    )
    best = diagnose(case, KINDS).verdict.best
    assert best.effect.name == name
    assert best.holdout > 24  # twice the margin
    true = 1 / hung["stiffness"] if name == "joint_flexibility" else hung["gap"]
    assert best.parameters[0].value == pytest.approx(
        true, rel=0.25
    )  # found on a grid, with a damping that is not its own
    wrong = Problem(problem.model, (hung_log(hung["stiffness"] * 20, hung["damping"], 0.0, seed=1, waves=OTHER),))
    stiff = diagnose(Case(problem, case.theta, holdout=wrong), KINDS)
    assert all(
        one.refuted for one in stiff.found if one.effect.name == name and one.holdout is not None and one.score > 24
    )


def test_a_stiff_link_hangs_on_nothing():
    """80 Hz and no gap: beyond what these equations see."""
    d = best_of(hung_log(stiffness=MASS * (2 * np.pi * 80.0) ** 2, damping=2000.0, gap=0.0))
    assert d.verdict.status == "nothing_missing"


def test_an_inertia_of_next_to_nothing_says_nothing():
    """Found on the wrist of a TX40 at 5 kHz: a fitted inertia below zero, and a march that overflowed."""
    t = np.arange(2000) / 1000
    for inertia in (np.full(2000, -0.1), np.where(t < 1, 0.1, 1e-9)):
        force, bend = _lag(t, inertia, np.sin(9 * t), _springs(np.array([3.0, 40.0])))
        assert np.isfinite(force).all() and np.isfinite(bend).all()
        assert np.abs(force).max() < 1e3
