"""The solver on rows: exact where it can be, unbiased, weighted joint by joint, and clear about what it cannot give."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from chebid.equations import JointNoise, Rows
from chebid.errors import NoAnswerError
from chebid.estimators.weighted import solve
from chebid.robots import Parameter

seeds = st.integers(0, 2**32 - 1)


def named(count):
    return tuple(Parameter(f"p{i}", None, "1") for i in range(count))


def rows_of(W, Y, joint=None):
    """Rows of a system as if they came from a projection."""
    joint = np.zeros(len(Y), dtype=int) if joint is None else joint
    system = np.column_stack([W, Y])
    noise = tuple(
        JointNoise(system[joint == j].T @ system[joint == j], int(np.sum(joint == j)), float(np.sum(joint == j)))
        for j in range(joint.max() + 1)
    )
    return Rows(W, Y, joint, np.linspace(0.1, 5.0, len(Y)), np.zeros(len(Y), dtype=int), noise)


def system(rng, count=60, width=4, joints=2):
    """W, theta, joint of a well-conditioned system."""
    joint = np.repeat(np.arange(joints), count)
    return rng.standard_normal((joints * count, width)), rng.standard_normal(width), joint


@given(seeds)
def test_without_noise_the_answer_is_exact(seed):
    W, theta, joint = system(np.random.default_rng(seed))
    found = solve(rows_of(W, W @ theta, joint), named(4))
    np.testing.assert_allclose(found.theta, theta, rtol=0, atol=1e-12 * np.abs(theta).max() * found.condition)
    assert np.all(found.sigma < 1e-10)


@given(seeds)
def test_one_joint_is_ordinary_least_squares(seed):
    """Eq. 22, 24, 25 from numpy: sigma^2 = ||r||^2 / (rows - parameters), C = sigma^2 (W^T W)^-1."""
    rng = np.random.default_rng(seed)
    W, theta, _ = system(rng, joints=1)
    Y = W @ theta + 0.3 * rng.standard_normal(len(W))
    found = solve(rows_of(W, Y), named(4))
    expected, rss, _, singular = np.linalg.lstsq(W, Y)
    np.testing.assert_allclose(found.theta, expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.white, rss[0] / (len(Y) - 4) * np.linalg.inv(W.T @ W), rtol=1e-8, atol=1e-15)
    assert found.condition == pytest.approx(singular[0] / singular[-1], rel=1e-9)


def test_weights_are_the_inverse_noises():
    rng = np.random.default_rng(0)
    W, theta, joint = system(rng, count=2000)
    noise = np.array([3.0, 0.1])
    found = solve(rows_of(W, W @ theta + noise[joint] * rng.standard_normal(len(W)), joint), named(4))
    np.testing.assert_allclose(found.sigma, noise, rtol=0.06)  # 1 / sqrt(2 * 2000) is 1.6 %


def test_weights_make_the_quiet_joint_count():
    """Errors against those of unweighted least squares, over 50 draws: the noises differ by ten."""
    weighted, plain = [], []
    for seed in range(50):
        rng = np.random.default_rng(seed)
        W, theta, joint = system(rng)
        Y = W @ theta + np.array([1.0, 0.1])[joint] * rng.standard_normal(len(W))
        weighted.append(solve(rows_of(W, Y, joint), named(4)).theta - theta)
        plain.append(np.linalg.lstsq(W, Y)[0] - theta)
    assert np.std(plain) > 4 * np.std(weighted)


@given(seeds, st.floats(-6, 6), st.lists(st.floats(-6, 6), min_size=4, max_size=4))
def test_units_scale_the_answer_and_nothing_else(seed, torque, columns):
    """Torques in other units, parameters in other units: everything follows (10^-6 .. 10^6)."""
    rng = np.random.default_rng(seed)
    W, theta, joint = system(rng)
    Y = W @ theta + np.array([1.0, 0.1])[joint] * rng.standard_normal(len(W))
    gain, scale = 10.0**torque, 10.0 ** np.array(columns)
    base = solve(rows_of(W, Y, joint), named(4))
    other = solve(rows_of(gain * W * scale, gain * Y, joint), named(4))
    np.testing.assert_allclose(other.theta * scale, base.theta, rtol=1e-6)
    np.testing.assert_allclose(np.sqrt(np.diag(other.covariance)) * scale, np.sqrt(np.diag(base.covariance)), rtol=1e-5)
    np.testing.assert_allclose(other.sigma, gain * base.sigma, rtol=1e-5)


@given(seeds, st.randoms(use_true_random=False))
def test_the_order_of_rows_does_not_matter(seed, shuffle):
    rng = np.random.default_rng(seed)
    W, theta, joint = system(rng, count=30)
    Y = W @ theta + rng.standard_normal(len(W))
    order = list(range(len(Y)))
    shuffle.shuffle(order)
    base, rows = solve(rows_of(W, Y, joint), named(4)), rows_of(W, Y, joint)
    mixed = Rows(W[order], Y[order], joint[order], rows.frequency[order], rows.block[order], rows.noise)
    found = solve(mixed, named(4))
    np.testing.assert_allclose(found.theta, base.theta, rtol=1e-7)
    np.testing.assert_allclose(found.covariance, base.covariance, rtol=1e-5, atol=1e-12)


@given(seeds)
def test_extra_weights_of_zero_leave_rows_out(seed):
    rng = np.random.default_rng(seed)
    W, theta, _ = system(rng, joints=1)
    Y = W @ theta + 0.1 * rng.standard_normal(len(W))
    Y[::7] += 100
    extra = np.ones(len(Y))
    extra[::7] = 0
    kept = extra > 0
    found = solve(rows_of(W, Y), named(4), extra)
    np.testing.assert_allclose(found.theta, np.linalg.lstsq(W[kept], Y[kept])[0], rtol=1e-7, atol=1e-10)


@given(seeds)
def test_honest_is_a_covariance(seed):
    rng = np.random.default_rng(seed)
    W, theta, joint = system(rng, count=20)
    found = solve(rows_of(W, W @ theta + rng.standard_normal(len(W)), joint), named(4))
    np.testing.assert_allclose(found.covariance, found.covariance.T, rtol=1e-9, atol=1e-15)
    assert np.linalg.eigvalsh(found.covariance).min() > 0


# --- rank ---------------------------------------------------------------------------------------------------------


def test_a_column_of_zeros_is_named():
    W, theta, joint = system(np.random.default_rng(0))
    W[:, 2] = 0
    with pytest.raises(NoAnswerError, match=r"lost rank: the data say nothing about p2$") as caught:
        solve(rows_of(W, W @ theta, joint), named(4))
    assert "excite" in caught.value.hint


def test_two_parameters_that_cannot_be_told_apart_are_named():
    W, theta, joint = system(np.random.default_rng(0))
    W[:, 3] = -2 * W[:, 1]
    with pytest.raises(NoAnswerError, match="only combinations of p1, p3 show in the data"):
        solve(rows_of(W, W @ theta, joint), named(4))


@given(seeds, st.lists(st.floats(-8, 8), min_size=4, max_size=4))
def test_rank_does_not_depend_on_units(seed, columns):
    """kg.m^2 or g.mm^2: nine decades between columns are no loss of rank, and hide none."""
    rng = np.random.default_rng(seed)
    W, theta, joint = system(rng)
    scale = 10.0 ** np.array(columns)
    solve(rows_of(W * scale, W @ theta + rng.standard_normal(len(W)), joint), named(4))
    W[:, 3] = W[:, 1]
    with pytest.raises(NoAnswerError, match="p1, p3"):
        solve(rows_of(W * scale, W @ theta, joint), named(4))


@given(seeds, st.integers(1, 3))
def test_fewer_rows_than_parameters(seed, count):
    rng = np.random.default_rng(seed)
    W, theta, _ = system(rng, count=count, joints=1)
    assume(np.abs(W).min() > 1e-3)
    with pytest.raises(NoAnswerError, match="lost rank"):
        solve(rows_of(W, W @ theta), named(4))
