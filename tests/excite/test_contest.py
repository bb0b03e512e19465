"""How well a rival can pass for another: against plain least squares, and against differences."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rigs import scara

from chebid.dynamics import Dynamics, make_dynamics
from chebid.effects import Effect, Motion
from chebid.effects.friction import Stribeck, ViscousPower, ViscousQuadratic
from chebid.effects.position import CubicSpring, HardStop, Spring, TorqueRipple
from chebid.excite.contest import Contest, Duel, Piece, Truth
from chebid.excite.limits import Limits
from chebid.excite.points import Points
from chebid.excite.separation import Separation

LIMITS = Limits(np.array([1.5, 2.2]), np.array([4.0, 8.0]), np.array([12.0, 40.0]))
NOISE, GATE = np.array([0.25, 0.025]), np.array([0.04, 0.08])
FAMILY = Points(LIMITS, 10.0, 6, uneven=True)
T = np.linspace(0.0, 10.0, 250)
DYNAMICS = make_dynamics(scara())


def motion_of(seed: int) -> np.ndarray:
    """A vector of `FAMILY`."""
    return FAMILY.random(np.random.default_rng(seed))


def contest(truth: Effect, *imitators: Effect, values: tuple[float, ...] = (1.0,)) -> Contest:
    """One duel."""
    return Contest(DYNAMICS, (Truth(0, truth, np.array(values)),), ((truth,), imitators), (Duel(0, 1),))


def separation(one: Contest) -> Separation:
    return Separation(one, T, NOISE, GATE)


def naive(dynamics: Dynamics, truth: Truth, imitator: Effect, state: np.ndarray) -> float:
    """E by least squares on all columns at once, row by row."""
    motion = Motion(T, *state)
    W, A, B = dynamics.regressor(motion), dynamics.block(truth.effect, motion), dynamics.block(imitator, motion)
    rows, a = [], []
    for n in range(len(T)):
        for j in range(2):
            speed = state[1, n, j]
            weight = speed**2 / (speed**2 + GATE[j] ** 2) / NOISE[j]
            rows.append(weight * np.concatenate([W[n, j], B[n, j]]))
            a.append(weight * A[n, j] @ truth.values)
    table = np.array(rows)
    x = np.linalg.lstsq(table, np.array(a), rcond=1e-12)[0]
    if imitator.one_way and x[-1] < 0:  # it cannot imitate with a sign that it cannot have
        table = table[:, :-1]
        x = np.linalg.lstsq(table, np.array(a), rcond=1e-12)[0]
    return float(np.sum((np.array(a) - table @ x) ** 2))


PAIRS = [
    (contest(Spring(1), HardStop(1, qs=0.5), values=(0.02, 0.01)), HardStop(1, qs=0.5)),
    (contest(HardStop(1, qs=0.5), CubicSpring(1, q0=0.3)), CubicSpring(1, q0=0.3)),
    (contest(ViscousPower(1, alpha=0.5), ViscousQuadratic(1)), ViscousQuadratic(1)),
    (contest(Stribeck(1, vs=0.8), TorqueRipple(1, k=2.0, harmonics=2)), TorqueRipple(1, k=2.0, harmonics=2)),
]


@pytest.mark.parametrize(("one", "imitator"), PAIRS)
def test_what_is_left_is_that_of_least_squares(one: Contest, imitator: Effect) -> None:
    state = FAMILY.motion(motion_of(1), T)
    (outcome,) = one.outcomes([separation(one).piece(T, state)])
    wanted = naive(DYNAMICS, one.truths[0], imitator, state)
    # both lose digits of the whole in the difference of squares: 1e-9 of it is far above rounding
    assert outcome.left[0] == pytest.approx(wanted, rel=1e-6, abs=1e-9 * outcome.most)
    assert one.imitated(Duel(0, 1), [separation(one).piece(T, state)])(imitator) == pytest.approx(outcome.left[0])


@pytest.mark.parametrize("one", [pair[0] for pair in PAIRS])
def test_the_gradient_is_that_of_differences(one: Contest) -> None:
    search = separation(one)
    x = motion_of(2)
    slope = FAMILY.gradient(x, T, search.objective(FAMILY.motion(x, T))[1])
    step = 1e-6
    for i in range(0, len(x), 2):
        away = np.where(np.arange(len(x)) == i, step, 0.0)
        ends = [search.objective(FAMILY.motion(x + sign * away, T))[0] for sign in (1, -1)]
        # a direction that changes between the two ends is worth up to some 1e-3 of the steepest slope
        assert slope[i] == pytest.approx((ends[0] - ends[1]) / (2 * step), rel=1e-2, abs=3e-3 * np.abs(slope).max())


@given(st.integers(0, 10_000), st.floats(0.1, 10.0))
def test_it_grows_with_the_square_of_the_truth_and_falls_with_more_settings(seed: int, size: float) -> None:
    state = FAMILY.motion(motion_of(seed), T)
    few = contest(Stribeck(1, vs=0.5), CubicSpring(1, q0=0.0))
    large = contest(Stribeck(1, vs=0.5), CubicSpring(1, q0=0.0), CubicSpring(1, q0=1.0), values=(size,))
    piece = separation(few).piece(T, state)
    (one,), (more,) = few.outcomes([piece]), large.outcomes([piece])
    assert more.left[0] == pytest.approx(size**2 * one.left[0], rel=1e-9)
    assert more.left.min() <= more.left[0] <= more.most


def test_logs_add_up_to_at_least_their_sum() -> None:
    one = contest(Spring(1), HardStop(1, qs=-0.5), HardStop(1, qs=-1.0), values=(0.02, 0.01))
    pieces = [separation(one).piece(T, FAMILY.motion(motion_of(seed), T)) for seed in (3, 4)]
    alone = [one.outcomes([piece])[0].left.min() for piece in pieces]
    assert one.outcomes(pieces)[0].left.min() >= sum(alone)


def test_a_rival_that_would_have_to_be_negative_does_not_imitate() -> None:
    one = contest(Stribeck(1, vs=0.8), ViscousPower(1, alpha=0.5))  # bends the other way
    other = contest(Stribeck(1, vs=0.8), Stribeck(1, vs=0.7))
    piece = separation(one).piece(T, FAMILY.motion(motion_of(5), T))
    (outcome,), (near,) = one.outcomes([piece]), other.outcomes([piece])
    assert outcome.left[0] == outcome.most
    assert outcome.values[0, 0] == 0.0
    assert near.left[0] < 0.1 * near.most


def test_samples_left_out_count_as_those_that_stand_for_them() -> None:
    one = contest(ViscousPower(1, alpha=0.5), ViscousQuadratic(1))
    t = np.linspace(0.0, 10.0, 3001)
    motion = Motion(t, *FAMILY.motion(motion_of(6), t))
    weight = np.ones_like(motion.q)
    whole, third = Piece(motion, weight), Piece(motion, np.sqrt(3) * weight, 3)
    (all_,), (some,) = one.outcomes([whole]), one.outcomes([third])
    assert some.left[0] == pytest.approx(all_.left[0], rel=2e-2)  # the error of a sum over every third sample
