"""Dry friction in the simulator: exact solutions, and the laws of Coulomb on every sample."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rigs import coasting, run, scara, slide, values, waves

from chebid.dynamics import make_dynamics
from chebid.effects import Motion
from chebid.effects.forward import CREEP
from chebid.errors import NoAnswerError
from chebid.model import Model, read_model
from chebid.model.schema import EffectSpec
from chebid.results import fitted_values
from chebid.simulate import Reference, read_reference, simulate

MASS, FORCE = 2.0, 3.0
ROUNDING = 1e-12  # of lengths near 1 m after some 1000 steps


def block(speed: float, duration: float, **options):
    model = slide(["coulomb"])
    return run(model, values(model, M1=MASS, Fs1=FORCE), coasting(speed, duration), **options)


@pytest.mark.parametrize("speed", [1.7, -0.3, 1e-3])
def test_sliding_block_stops_where_it_must_and_stays(speed):
    log = block(speed, 2.0)
    stop = speed * abs(speed) * MASS / (2 * FORCE)
    assert log.q_true[-1, 0] == pytest.approx(stop, rel=ROUNDING)
    resting = log.t > abs(speed) * MASS / FORCE
    assert np.ptp(log.q_true[resting]) == 0
    assert not log.dq[resting].any() and not log.ddq[resting].any()
    assert log.sticks[resting].all() and not log.sticks[~resting & (log.t > 0)].any()


def test_sliding_block_on_its_way():
    log = block(1.0, 1.0)
    moving = log.t < MASS / FORCE
    t = log.t[moving]
    np.testing.assert_allclose(log.q_true[moving, 0], t - FORCE / MASS * t**2 / 2, atol=ROUNDING)
    np.testing.assert_allclose(log.ddq[moving], -FORCE / MASS, rtol=ROUNDING)


@given(share=st.floats(0, 1, exclude_max=True))
@settings(max_examples=20)
def test_sticks_for_ever_below_the_level(share):
    # the reference leaves at once and for good: a constant pull of share * FORCE
    model = slide(["coulomb"], kp=share * FORCE)
    t = np.array([0.0, 0.005, 3.0])
    away = Reference(t, np.array([[0.0], [1.0], [1.0]]), np.zeros((3, 1)))
    log = run(model, values(model, M1=MASS, Fs1=FORCE), away)
    assert not log.q_true.any() and not log.dq.any() and log.sticks.all()


def test_breaks_away_when_the_load_reaches_the_level():
    # the pull kp r(t) grows with 20 N/s, in steps of the control period
    model = slide(["coulomb"], kp=20.0)
    t = np.arange(101) / 100
    log = run(model, values(model, M1=MASS, Fs1=FORCE), Reference(t, t[:, None], np.zeros((101, 1))))
    first = np.flatnonzero(20.0 * t > FORCE)[0]
    assert log.sticks[:first, 0].all() and not log.q_true[: first + 1].any()
    assert not log.sticks[first:, 0].any() and (log.dq[first + 1 :] > 0).all()
    assert log.ddq[first, 0] == pytest.approx((20.0 * t[first] - FORCE) / MASS, rel=1e-9)


def test_friction_that_grows_with_the_load_breaks_away_at_the_level_at_which_it_slips():
    """Found by the hidden-effect study: a level that jumped between the two let a joint stick and slip without end.

    u = (1 + mu)(M ddq + Fs) when it slips, and so it holds up to u = (1 + mu) Fs.
    """
    growth = 1.25
    model = slide(["coulomb", "load_friction"], kp=20.0)
    t = np.arange(101) / 100
    pull = Reference(t, t[:, None], np.zeros((101, 1)))
    log = run(model, values(model, M1=MASS, Fs1=FORCE, mu1=growth - 1), pull)
    first = np.flatnonzero(20.0 * t > growth * FORCE)[0]
    assert log.sticks[:first, 0].all() and not log.sticks[first:, 0].any()
    assert log.ddq[first, 0] == pytest.approx((20.0 * t[first] / growth - FORCE) / MASS, rel=1e-9)


def test_turns_round_exactly():
    """A block thrown against a constant pull above the level: it slows down, turns, and comes back more slowly."""
    pull = 5.0
    model = slide(["coulomb", "offset"])
    log = run(model, values(model, M1=MASS, Fs1=FORCE, Foff1=pull), coasting(2.0, 2.0))
    there, back = (pull + FORCE) / MASS, (pull - FORCE) / MASS
    turn = 2.0 / there
    t = log.t
    exact = np.where(t < turn, 2 * t - there * t**2 / 2, 2 * turn - there * turn**2 / 2 - back * (t - turn) ** 2 / 2)
    np.testing.assert_allclose(log.q_true[:, 0], exact, atol=10 * ROUNDING)
    assert not log.sticks[1:].any()


def test_stops_at_a_turn_when_the_pull_is_below_the_level():
    model = slide(["coulomb", "offset"])
    log = run(model, values(model, M1=MASS, Fs1=FORCE, Foff1=2.0), coasting(2.0, 2.0))
    assert log.q_true[-1, 0] == pytest.approx(2.0**2 / (2 * 5.0 / MASS), rel=ROUNDING)
    assert log.sticks[-1, 0] and np.ptp(log.q_true[log.t > 0.81]) == 0


def test_viscous_decay():
    model = slide(["viscous"])
    log = run(model, values(model, M1=MASS, Fv1=4.0), coasting(1.0, 2.0))
    np.testing.assert_allclose(log.dq[:, 0], np.exp(-2 * log.t), rtol=1e-10)


def test_stribeck_lets_go_with_a_jerk():
    """Level at rest Fs + Fst; as soon as the block moves, less."""
    model = slide(["coulomb", {"effect": "stribeck", "vs": 0.01}], kp=20.0)
    t = np.arange(201) / 100
    log = run(model, values(model, M1=MASS, Fs1=2.0, Fst1=1.0), Reference(t, t[:, None], np.zeros((201, 1))))
    first = np.flatnonzero(20.0 * t > 3.0)[0]
    assert not log.q_true[: first + 1].any()
    late = log.dq[:, 0] > 0.1  # beyond the Stribeck velocity the level is that of Coulomb
    np.testing.assert_allclose((log.torque - MASS * log.ddq)[late], 2.0, atol=1e-9)


@given(
    levels=st.tuples(st.floats(0, 5), st.floats(0, 2)),
    gains=st.tuples(st.floats(1, 500), st.floats(0.1, 30)),
    size=st.floats(0.001, 1.0),
)
@settings(max_examples=40)
def test_laws_of_coulomb_with_coupled_joints(levels, gains, size):
    """On every sample: friction is the level against the motion, or anything up to it at rest with no acceleration."""
    model = scara(control={"kp": list(gains), "kd": [g / 15 for g in gains], "rate": 200})
    theta = values(model, Fs1=levels[0], Fs2=levels[1])
    log = run(model, theta, waves(2.0, size=(size, size)))
    rest = values(model, Fs1=0.0, Fs2=0.0)
    friction = log.torque - make_dynamics(model).torque(Motion(log.t, log.q_true, log.dq, log.ddq), rest)
    slack = 1e-9 * (1 + np.abs(log.torque).max())
    assert (np.abs(friction) <= np.array(levels) + slack).all()
    sliding = log.dq != 0
    assert (np.abs(friction - np.array(levels) * np.sign(log.dq))[sliding] <= slack).all()
    assert not (log.sticks & sliding).any()
    assert not log.ddq[log.sticks].any()
    starts = ~log.sticks & ~sliding  # about to move: already at the level, in the direction of the acceleration
    assert (np.abs(friction - np.array(levels) * np.sign(log.ddq))[starts] <= slack).all()


def test_one_joint_rests_while_the_other_drags_at_it():
    model = scara(control={"kp": [0, 60], "kd": [0, 2.6], "rate": 500})
    calm = run(model, values(model, Fs1=30.0), waves(2.0))
    assert not calm.q_true[:, 0].any() and np.abs(calm.dq[:, 1]).max() > 1
    dragged = run(model, values(model, Fs1=0.05), waves(2.0))
    assert dragged.q_true[:, 0].any() and 0 < dragged.sticks[1:, 0].mean() < 0.5


def time_stepping(levels, duration, step):
    """The slow twin: Moreau's time stepping of first order, friction by projected Gauss-Seidel, no events."""
    z1, z2, lx, ly = (3.45, 0.061, 0.124, 0.008)
    q, dq = np.zeros(2), np.array([0.4, -1.5])
    for _ in range(round(duration / step)):
        c, s = np.cos(q[1]), np.sin(q[1])
        coupling, slope = lx * c - ly * s, lx * s + ly * c
        mass = np.array([[z1 + z2 + 2 * coupling, z2 + coupling], [z2 + coupling, z2]])
        bias = np.array([-slope * dq[1] * (2 * dq[0] + dq[1]), slope * dq[0] ** 2])
        inverse = np.linalg.inv(mass)
        free = dq - step * inverse @ bias
        impulse = np.zeros(2)
        for _ in range(12):
            for j in range(2):
                v = free[j] - inverse[j] @ impulse
                impulse[j] = np.clip(impulse[j] + v / inverse[j, j], -step * levels[j], step * levels[j])
        dq = free - inverse @ impulse
        q = q + step * dq
    return q, dq


def test_agrees_with_time_stepping():
    """Two joints thrown and left alone until both rest: first-order errors of the twin halve with its step."""
    levels = (0.8, 0.13)
    model = scara(["coulomb"], control={"kp": 0, "kd": 0, "rate": 100})
    t = np.linspace(0, 3, 301)
    thrown = Reference(t, t[:, None] * [0.4, -1.5], np.tile([0.4, -1.5], (301, 1)))
    log = run(model, values(model, Fs1=levels[0], Fs2=levels[1]), thrown)
    assert log.sticks[-1].all()
    errors = [np.abs(time_stepping(levels, 3.0, step)[0] - log.q_true[-1]).max() for step in (8e-4, 4e-4)]
    assert errors[0] < 2e-3 and errors[1] < 0.7 * errors[0]


def grown(project, effect: EffectSpec, **more: float) -> tuple[Model, np.ndarray]:
    """The SCARA of config/ with one effect more, and its parameters."""
    plain = read_model(project / "config/scara.yaml")
    model = plain.model_copy(update={"effects": (*plain.effects, effect)})
    return model, values(model, **make_dynamics(plain).named(fitted_values(plain)), **more)


def test_the_friction_of_a_motor_of_two_joints(project):
    """Found by the hidden-effect study: it turns with the sum of two speeds, whose sign is the event of no joint."""
    motor = EffectSpec(effect="motor_coupling", joint="q1")
    model, theta = grown(project, motor, Iam1_2=0.016, Fvm1_2=0.033, Fsm1_2=0.084)
    for name in ("hidden_motion_1", "hidden_motion_2", "trajectory"):
        log = simulate(model, theta, read_reference(project / f"data/{name}.csv", model), seed=1)
        torque = make_dynamics(model).torque(Motion(log.t, log.q_true, log.dq, log.ddq), theta)
        # where no joint rests and the motor turns: elsewhere it creeps
        turning = (log.dq != 0).all(axis=1) & (np.abs(log.dq.sum(axis=1)) > 20 * CREEP)
        assert turning.mean() > 0.3
        np.testing.assert_allclose(torque[turning], log.torque[turning], atol=1e-10 * np.abs(log.torque).max())


def test_chatter_ends_with_an_error_and_not_never(project):
    """A law of its own with a sign that is the event of no joint."""
    law = EffectSpec(effect="mine", joint="q2", formula="sign(dq1 + dq2)", symbol="Fm", unit="N.m")
    model, theta = grown(project, law, Fm2=0.5)
    with pytest.raises(NoAnswerError, match=r"sticks and slips|cannot be followed"):
        simulate(model, theta, read_reference(project / "data/hidden_motion_2.csv", model), seed=1)
