"""The forward forms against the columns: the same physics, one compiled and one vectorised."""

import numpy as np
import pytest
from effects.motions import RIGID, SCARA, STAGE, all_of, known, label, smooth
from hypothesis import given
from hypothesis import strategies as st

from chebid.dynamics import Dynamics
from chebid.effects import LIBRARY, Motion, make_effects
from chebid.effects.dahl import bristle
from chebid.effects.forward import BRISTLES, CHANNELS, FORWARDS, TWO_MASSES, bend, forward_form
from chebid.errors import UsageError
from chebid.model import Model


def states(seed: int, count: int = 40) -> Motion:
    """Unrelated instants: t from 0, states of both signs, rest included."""
    rng = np.random.default_rng(seed)
    t = np.sort(rng.uniform(0, 40, count))
    t[0] = 0.0
    q, dq, ddq, tau = rng.normal(0, 1.5, (4, count, 2))
    dq[1] = 0.0
    return Motion(t, q, dq, ddq, tau, RIGID)


FORMS = [effect for robot in (SCARA, STAGE) for effect in all_of(known(smooth(2, count=200), robot), robot)]
FORMS = [effect for effect in FORMS if effect.forward in FORWARDS]


@pytest.mark.parametrize("effect", FORMS, ids=label)
def test_forward_is_columns_times_parameters(effect):
    motion = states(len(label(effect)))
    form = FORWARDS[effect.forward]
    p = np.random.default_rng(3).uniform(-1, 1, len(effect.symbols))
    wanted = effect.block(motion) @ p
    found = np.zeros_like(wanted)
    for n in range(len(motion)):
        state = motion.t[n], motion.q[n], motion.dq[n], motion.ddq[n], motion.tau[n]
        for joint in effect.rows(2):
            level = form.function(*state, joint, p, effect.vector())
            found[n, joint] = level * np.sign(motion.dq[n, joint]) if form.dry else level
    # rounding: a few operations on numbers of the size of the columns
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-14 * max(1.0, np.abs(effect.block(motion)).max()))


def test_every_effect_acts_in_some_way():
    acting = {effect.name for effect in FORMS} | set(BRISTLES) | set(TWO_MASSES) | set(CHANNELS)
    assert acting == set(LIBRARY)


def test_dry_friction_is_what_has_the_direction_of_its_own_joint():
    dry = {name for name, form in FORWARDS.items() if form.dry}
    assert dry == {"coulomb", "stribeck", "load_friction", "friction_ripple", "coulomb_drift"}
    for name in dry:
        assert LIBRARY[name].kind in {"friction", "position", "time"}


@pytest.mark.parametrize("effect", FORMS, ids=label)
def test_affine_in_acceleration(effect):
    """So that the simulator may put it in the mass matrix."""
    m, form, p = states(1, 5), FORWARDS[effect.forward], np.ones(len(effect.symbols))
    for joint in effect.rows(2):
        at = [
            form.function(30.0, m.q[2], m.dq[2], x * m.ddq[2], m.tau[2], joint, p, effect.vector()) for x in (0, 1, 3)
        ]
        assert at[2] - at[0] == pytest.approx(3 * (at[1] - at[0]), abs=1e-12)


def test_the_general_form_is_the_same():
    for effect in FORMS:
        compiled, general = FORWARDS[effect.forward], forward_form(_without_form(effect))
        m, p = states(4, 3), np.linspace(0.5, 1.5, len(effect.symbols))
        for joint in effect.rows(2):
            args = (0.0, m.q[2], m.dq[2], m.ddq[2], m.tau[2], joint, p, effect.vector())
            one = compiled.function(*args) * (np.sign(m.dq[2, joint]) if compiled.dry else 1)
            assert general.function(*args) == pytest.approx(one, abs=1e-13)


def _without_form(effect):
    kind = type("Plain", (type(effect),), {"forward": ""})
    return kind(effect.joint, **effect.hyper).bind(
        SCARA if effect.rows(2) == (0, 1) and len(effect.symbols) == 4 else STAGE
    )


def test_a_formula_acts_too():
    entry = {
        "effect": "mine",
        "joint": "q2",
        "formula": "sign(dq)*exp(-abs(dq)/v0) + q1 + 0*tau_model",
        "hyper": {"v0": 0.1},
    }
    model = Model.model_validate({"robot": {"type": "scara"}, "joints": ["q1", "q2"], "effects": [entry]})
    (mine,) = make_effects(model)
    form, m = forward_form(mine), states(6)
    wanted = mine.block(m)[:, 1, 0]
    for n in range(len(m)):
        state = m.t[n], m.q[n], m.dq[n], m.ddq[n], m.tau[n]
        assert form.function(*state, 1, np.array([0.7]), mine.vector()) == pytest.approx(0.7 * wanted[n], abs=1e-14)
        assert form.function(*state, 0, np.array([0.7]), mine.vector()) == 0.0


@pytest.mark.parametrize("name", [*BRISTLES, *TWO_MASSES, *CHANNELS])
def test_what_one_instant_does_not_decide_is_refused(name):
    kind = LIBRARY[name]
    hypers = {key: 1.0 for key in kind.hypers()}
    with pytest.raises(UsageError, match=f"{name} has no torque at a single instant"):
        forward_form(kind(None if kind.whole_arm else 0, **hypers).bind(SCARA))


def test_bristles_bend_as_along_the_motion():
    """From turning point to turning point against the bend of the whole motion."""
    q, turns = np.array([0.0, 0.3, 0.7, 0.2, -0.4, -0.1]), [0, 2, 4]
    wanted, h = bristle(q, 0.2), np.array([0.2, 0.0, 0.0])
    for n in range(1, len(q)):
        if n - 1 in turns:
            h[1:] = q[n - 1], wanted[n - 1]
        assert bend(q[n], np.sign(q[n] - q[n - 1]), h) == pytest.approx(wanted[n], abs=1e-15)
    assert bend(q[-1], 0.0, h) == h[2], "at rest they stay as they are"


@given(delay=st.floats(0, 0.5))
def test_the_channel_delays(delay):
    t = np.linspace(0, 10, 1001)
    torque = np.column_stack([t, 2 * t])
    logged = CHANNELS["torque_delay"](t, torque, LIBRARY["torque_delay"](), np.array([delay]))
    late = t >= delay
    np.testing.assert_allclose(logged[late], torque[late] - delay * np.array([1, 2]), atol=1e-12)
    # to first order what the column says
    m = Motion(t, torque, torque, torque, torque)
    np.testing.assert_allclose(
        (logged - torque)[late], delay * LIBRARY["torque_delay"]().block(m)[late, :, 0], atol=1e-11
    )


def test_the_channel_clips():
    t = np.linspace(0, 1, 5)
    torque = np.column_stack([np.linspace(-4, 4, 5)] * 2)
    logged = CHANNELS["saturation"](t, torque, LIBRARY["saturation"](1, limit=1.5), np.zeros(0))
    assert logged[:, 0].tolist() == [-4, -2, 0, 2, 4] and logged[:, 1].tolist() == [-1.5, -1.5, 0, 1.5, 1.5]


def test_power_into_the_joints_is_the_same_by_either_form():
    """A model with many effects: torque by the regressor, and by summing forward forms."""
    motion = known(smooth(21, count=50))
    effects = tuple(LIBRARY[name](joint) for name in ("viscous", "coulomb", "offset", "spring") for joint in (0, 1))
    dynamics = Dynamics(SCARA, effects)
    theta = np.random.default_rng(0).uniform(0.1, 1, len(dynamics.parameters))
    total = SCARA.regressor(motion.q, motion.dq, motion.ddq) @ dynamics.rigid(theta)
    for effect, p in dynamics.terms(theta):
        form = forward_form(effect)
        for n in range(50):
            state = motion.t[n], motion.q[n], motion.dq[n], motion.ddq[n], motion.tau[n]
            value = form.function(*state, effect.joint, p, effect.vector())
            total[n, effect.joint] += value * (np.sign(motion.dq[n, effect.joint]) if form.dry else 1)
    np.testing.assert_allclose(total, dynamics.torque(motion, theta), atol=1e-12)
