"""The simulator against other roads to the same motion: inverse dynamics, pinocchio, energy, refined steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rigs import CONTROL, QUIET, TRUE, run, scara, slide, values, waves
from scipy.integrate import solve_ivp
from scipy.interpolate import BPoly

from chebid.dynamics import make_dynamics
from chebid.effects import Motion
from chebid.errors import InputError, NoAnswerError
from chebid.robots import Axes, Scara
from chebid.simulate import Options, Reference, simulate, simulate_batch
from chebid.simulate.compiled import compiled

EFFECTS = {
    "none": ([], {}),
    "friction of the paper": (["viscous", "coulomb"], {}),
    "asymmetric": (["viscous", "coulomb", "offset", "viscous_asymmetry"], {"Foff1": 0.3, "dFv2": 0.02}),
    "stribeck": (["coulomb", {"effect": "stribeck", "vs": 0.2}], {"Fst1": 0.5, "Fst2": 0.1}),
    "powers": (
        ["viscous_quadratic", {"effect": "viscous_power", "alpha": 0.5}],
        {"F21": 0.2, "F22": 0.01, "Fa1": 0.6, "Fa2": 0.05},
    ),
    "load": (["coulomb", "load_friction"], {"mu1": 0.1, "mu2": 0.15}),
    "gain": (["viscous", {"effect": "torque_gain", "joint": "q2"}], {"g2": 0.2}),
    "spring": (["coulomb", "spring"], {"k1": 3.0, "kq01": 0.5, "k2": 0.4, "kq02": -0.1}),
    "ripple": (["coulomb", {"effect": "friction_ripple", "k": 3}], {"ac1": 0.2, "as1": 0.1, "ac2": 0.02}),
    "cogging": ([{"effect": "torque_ripple", "k": 7}], {"bc1": 0.3, "bs2": 0.02}),
    "rotor": ([{"effect": "rotor_inertia", "joint": "q2"}, "viscous"], {"Ia2": 0.05}),
    "drift": (["coulomb", {"effect": "coulomb_drift", "T": 2.0}], {"dFsT1": 0.4, "dFsT2": -0.05}),
    "coupling": ([{"effect": "viscous_coupling", "joint": "q1", "source": "q2"}, "coulomb"], {"Fv1_2": 0.1}),
    "payload": (["viscous", {"effect": "payload", "t0": 1.0}], {"dZZR1": 0.3, "dZZ2": 0.03, "dLMX2": 0.05}),
    "tilt": (["coulomb", "base_tilt"], {"G1c": 1.0, "G2c": 0.2}),
    "push": ([{"effect": "external_push", "joint": "q2", "t0": 1.0, "width": 0.2}], {"P2": 0.5}),
}


@pytest.mark.parametrize("case", EFFECTS)
def test_inverse_model_gives_back_the_torque(case):
    """Regressor times theta on the true q, dq, ddq: the torque that was applied, wherever the joints move."""
    effects, others = EFFECTS[case]
    model = scara(effects)
    theta = values(model, **others)
    assert set(others) <= {p.name for p in make_dynamics(model).parameters}, "a value that acts on nothing"
    log = run(model, theta, waves(2.0), rate=500.0)
    dynamics = make_dynamics(model)
    torque = dynamics.torque(Motion(log.t, log.q_true, log.dq, log.ddq), theta)
    moving = (log.dq != 0).all(axis=1)
    assert moving.mean() > 0.9
    # load and gain are solved by iteration to 1e-14 of the acceleration
    np.testing.assert_allclose(torque[moving], log.torque[moving], atol=1e-10 * np.abs(log.torque).max())


def test_effects_in_python_act_as_the_compiled_ones():
    """A formula has no compiled form: its torque comes from its columns, level and rest told apart by direction."""
    formula = {
        "effect": "mine",
        "joint": "q2",
        "formula": "sign(dq)*exp(-(dq/v0)**2) + 0.5*q",
        "hyper": {"v0": 0.2},
        "symbol": "Fm",
        "unit": "N.m",
    }
    model = scara(["coulomb", formula])
    twin = scara(["coulomb", {"effect": "stribeck", "joint": "q2", "vs": 0.2}, {"effect": "spring", "joint": "q2"}])
    slow = run(model, values(model, Fm2=0.1), waves(1.0))
    fast = run(twin, values(twin, Fst2=0.1, k2=0.05), waves(1.0))
    np.testing.assert_allclose(slow.q_true, fast.q_true, atol=1e-11)
    np.testing.assert_array_equal(slow.sticks, fast.sticks)
    assert slow.sticks.any()


def test_any_robot_works_through_its_regressor():
    model = scara()
    fast = run(model, values(model), waves(1.0))
    slow = run(model, values(model), waves(1.0), generic=True)
    np.testing.assert_allclose(slow.q_true, fast.q_true, atol=1e-13)
    np.testing.assert_allclose(slow.ddq, fast.ddq, atol=1e-9)


state = st.tuples(*[st.floats(-3, 3)] * 4)


@given(state=state, theta=st.tuples(*[st.floats(-2, 2)] * 4))
def test_compiled_robots_are_those_of_the_regressor(state, theta):
    """Mass and bias of the compiled plants against the columns of the regressor, which is affine in ddq."""
    with compiled() as (_, plant):
        from chebid.simulate import plants

        for robot, function, p in (
            (Scara(("a", "b")), plants.scara, np.array(theta)),
            (Axes(("a", "b"), ("revolute", "prismatic")), plants.axes, np.array(theta[:2])),
        ):
            q, dq = np.array(state[:2]), np.array(state[2:])
            results = [(np.empty((2, 2)), np.empty(2)) for _ in range(2)]
            function(q, dq, p, *results[0])
            plant.RegressorPlant(robot, p)(q, dq, *results[1])
            for one, other in zip(*results, strict=True):
                np.testing.assert_allclose(one, other, atol=1e-13 * (1 + 50 * np.abs(theta).max()))


def pinocchio_arm():
    """A planar arm of two links with the base parameters of the SCARA, gravity across its axes."""
    pin = pytest.importorskip("pinocchio")
    length, mass = 0.5, 2.0  # any: eq. 19 regroups them
    z1, z2, lx, ly = (TRUE[name] for name in ("ZZR1", "ZZ2", "LMX2", "LMY2"))
    centre = np.array([lx, ly, 0.0]) / (length * mass)
    arm = pin.Model()
    arm.gravity = pin.Motion.Zero()
    first = arm.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "q1")
    second = arm.addJoint(first, pin.JointModelRZ(), pin.SE3(np.eye(3), np.array([length, 0.0, 0.0])), "q2")

    def body(mass, centre, about_joint):
        about_centre = about_joint - mass * centre @ centre
        return pin.Inertia(mass, centre, np.diag([1.0, 1.0, about_centre]))

    arm.appendBodyToJoint(first, body(1.0, np.zeros(3), z1 - mass * length**2), pin.SE3.Identity())
    arm.appendBodyToJoint(second, body(mass, centre, z2), pin.SE3.Identity())
    return pin, arm, arm.createData()


def test_agrees_with_pinocchio_at_every_step():
    """Accelerations, and one control period of motion under the held torque, from each state on: to 1e-9."""
    pin, arm, data = pinocchio_arm()
    model = scara(["viscous"])
    log = run(model, values(model), waves(1.0), rate=500.0)
    viscous = np.array([TRUE["Fv1"], TRUE["Fv2"]])
    for k in range(0, 500, 7):
        q, dq, torque = log.q_true[k], log.dq[k], log.torque[k]
        np.testing.assert_allclose(pin.aba(arm, data, q, dq, torque - viscous * dq), log.ddq[k], rtol=1e-9, atol=1e-9)

        def rate(_, y, torque=torque):
            return np.concatenate([y[2:], pin.aba(arm, data, y[:2], y[2:], torque - viscous * y[2:])])

        end = solve_ivp(rate, (0, 0.002), np.concatenate([q, dq]), method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
        np.testing.assert_allclose(end, np.concatenate([log.q_true[k + 1], log.dq[k + 1]]), rtol=0, atol=1e-9)


def kinetic(log):
    c, s = np.cos(log.q_true[:, 1]), np.sin(log.q_true[:, 1])
    coupling = TRUE["LMX2"] * c - TRUE["LMY2"] * s
    first, second = log.dq.T
    total = TRUE["ZZR1"] + TRUE["ZZ2"] + 2 * coupling
    return (total * first**2 + 2 * (TRUE["ZZ2"] + coupling) * first * second + TRUE["ZZ2"] * second**2) / 2


def test_energy_is_kept():
    """Work of the drives = kinetic energy + friction: exactly over held torques, friction by Simpson at 20 kHz."""
    model = scara()
    log = run(model, values(model), waves(1.0), rate=20_000.0)
    work = np.concatenate([[0.0], np.cumsum((log.torque[:-1] * np.diff(log.q_true, axis=0)).sum(axis=1))])
    loss = (np.array([0.03, 0.012]) * log.dq**2 + np.array([0.8, 0.13]) * np.abs(log.dq)).sum(axis=1)
    lost = np.concatenate([[0.0], np.cumsum((loss[:-1] + loss[1:]) / 2 * np.diff(log.t))])
    # the trapezoids of 5e-5 s are wrong by loss'' h^2/12, and by a kink at each reversal
    np.testing.assert_allclose(work, kinetic(log) + lost, atol=1e-7 * np.abs(work).max())


def test_runge_kutta_is_of_order_four():
    """Without step control, halving the step divides the error by 16."""
    model = scara(["viscous", "spring"], control={"kp": 0, "kd": 0, "rate": 5})
    theta = values(model, k1=20.0, k2=2.0)
    t = np.arange(21) / 5
    thrown = Reference(t, t[:, None] * [1.0, -2.0], np.tile([1.0, -2.0], (21, 1)))
    ends = []
    for step in (0.2, 0.1, 0.05, 0.00625):
        ends.append(run(model, theta, thrown, step=step, tolerance=1e9).q_true[-1])
    errors = [np.abs(end - ends[-1]).max() for end in ends[:-1]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert (orders > 3.7).all() and (orders < 5).all(), orders


@pytest.mark.parametrize("effects", [["viscous", "coulomb"], ["coulomb", {"effect": "stribeck", "vs": 0.02}]])
def test_halving_the_steps_changes_nothing(effects):
    """Positions to 1e-9, over stops and starts, with perfect encoders."""
    model = scara(effects)
    theta = values(model, Fst1=0.3, Fst2=0.05)
    usual = run(model, theta, waves(5.0))
    fine = run(model, theta, waves(5.0), step=2.5e-4)
    finer = run(model, theta, waves(5.0), tolerance=1e-14)
    assert np.abs(fine.q_true - usual.q_true).max() < 1e-9
    assert np.abs(finer.q_true - usual.q_true).max() < 1e-9


def test_zero_order_hold_and_control_law():
    """The drive's torque comes from the encoders of this instant and the one before, and is held."""
    model = scara(sensors={"encoder": 1.6e-4}, control=CONTROL | {"rate": 100})
    log = run(model, values(model), waves(1.0), rate=100.0)
    reference = waves(1.0)
    before = np.vstack([log.q[:1], log.q[:-1]])
    speed = (log.q - before) * 100
    kp, kd = np.array(CONTROL["kp"]), np.array(CONTROL["kd"])
    expected = kp * (reference.q - log.q) + kd * (reference.dq - speed)
    np.testing.assert_allclose(log.torque, expected, atol=1e-8)
    dense = run(model, values(model), waves(1.0), rate=1000.0)
    np.testing.assert_array_equal(
        dense.torque[:-1].reshape(-1, 10, 2)[:, 1:] - dense.torque[:-1].reshape(-1, 10, 2)[:, :1], 0
    )


@pytest.mark.parametrize("orders", [2, 3])
def test_a_reference_is_its_hermite_polynomial(orders):
    """scipy builds it interval by interval; numbers of order 1 / step^2 = 4e4 lose five digits of sixteen."""
    random = np.random.default_rng(0)
    t = np.concatenate([[0.0], np.cumsum(random.uniform(0.005, 0.015, 50))])
    known = random.standard_normal((51, orders, 2))
    at = random.uniform(0, t[-1], 300)
    slow = BPoly.from_derivatives(t, known)
    made = Reference(t, *np.moveaxis(known, 1, 0)).at(at)
    np.testing.assert_allclose(made, [slow(at), slow.derivative()(at)], rtol=0, atol=1e-10)


def test_starts_with_the_velocity_of_the_reference():
    model = slide(["viscous"], kp=100.0, kd=20.0)
    t = np.arange(101) / 100
    log = run(model, values(model, M1=1.0, Fv1=0.0), Reference(t, 2 * t[:, None], np.full((101, 1), 2.0)))
    np.testing.assert_allclose(log.q_true[:, 0], 2 * t, atol=1e-12)
    np.testing.assert_allclose(log.torque, 0, atol=1e-9)


def test_saturation_clips_the_drive_and_delay_shifts_the_log():
    model = scara(["viscous", {"effect": "saturation", "joint": "q1", "limit": 5.0}])
    log = run(model, values(model), waves(2.0))
    assert np.abs(log.torque[:, 0]).max() == 5.0 < np.abs(run(scara(), values(scara()), waves(2.0)).torque[:, 0]).max()
    late = scara(["viscous", "torque_delay"])
    there = run(late, values(late, delay=0.02), waves(2.0)).tau
    here = run(late, values(late), waves(2.0)).tau
    np.testing.assert_allclose(there[5:-3], here[3:-5], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"ZZ2": -0.061}, "not positive definite"),
        ({"ZZR1": 1e-9, "LMX2": 3.0}, "not positive definite"),
        ({"ZZR1": 0.005, "LMX2": 0.0, "LMY2": 0.0}, "beyond all bounds"),
    ],
)
def test_impossible_models_are_refused_in_words(change, message):
    model = scara()
    with pytest.raises(NoAnswerError, match=message) as caught:
        run(model, values(model, **change), waves(2.0))
    assert "t = " in str(caught.value) and caught.value.hint


@pytest.mark.parametrize("section", ["control", "sensors"])
def test_missing_sections(section):
    model = scara().model_copy(update={section: None})
    with pytest.raises(InputError, match="has no") as caught:
        run(model, values(scara()), waves(1.0))
    assert f"{section}: {{" in caught.value.hint


def test_same_seed_same_bytes_and_batches():
    model = scara(sensors={"encoder": 1.6e-4, "torque_noise": [0.25, 0.025]})
    theta, reference = values(model), waves(1.0)
    one, two = (simulate(model, theta, reference, seed=3) for _ in range(2))
    other = simulate(model, theta, reference, seed=4)
    batch = simulate_batch(model, theta, reference, [4, 3])
    assert one.q.tobytes() == two.q.tobytes() == batch[1].q.tobytes()
    assert one.tau.tobytes() == two.tau.tobytes() == batch[1].tau.tobytes()
    assert other.tau.tobytes() == batch[0].tau.tobytes() != one.tau.tobytes()
    assert other.q_true.tobytes() != one.q_true.tobytes()


def test_two_hundred_seeds_take_seconds():
    model = scara(sensors={"encoder": 1.6e-4, "torque_noise": [0.25, 0.025]})
    logs = simulate_batch(model, values(model), waves(8.0), range(20))
    # 200 seeds would take 10 times as long; 60 ms each on an idle machine, 4 times that on a busy one
    import time

    start = time.process_time()
    simulate_batch(model, values(model), waves(8.0), range(10))
    assert time.process_time() - start < 4
    assert len({log.tau.tobytes() for log in logs}) == 20


def test_options_that_mean_nothing():
    model = scara()
    for options, message in (
        (Options(rate=-1), "rate"),
        (Options(duration=float("nan")), "duration"),
        (Options(noise="pink"), "pink"),
        (Options(torque_log="sometimes"), "sometimes"),
    ):
        with pytest.raises(Exception, match=message):
            simulate(model, values(model), waves(1.0), options=options)
    assert QUIET.noise == "none"
