"""The revised Durbin-Wu-Hausman test: size, power, and instruments that say nothing."""

from dataclasses import replace

import numpy as np
import pytest

from chebid.equations import JointNoise, Rows
from chebid.estimators.consistency import Consistency, hausman

ROWS, SIGMA = 120, np.array([0.5, 0.05])
THETA = np.array([2.0, -1.0, 0.5])


def rows(W: np.ndarray, Y: np.ndarray) -> Rows:
    joint = np.repeat([0, 1], ROWS // 2)
    noise = tuple(JointNoise(np.eye(4), ROWS // 2, ROWS / 2) for _ in range(2))
    return Rows(W, Y, joint, np.ones(ROWS), np.zeros(ROWS, dtype=int), noise)


def trial(seed: int, endogenous: float) -> float:
    """p value where W = Z + V and the residuals hold `endogenous` times the first column of V."""
    random = np.random.default_rng(seed)
    sigma = np.repeat(SIGMA, ROWS // 2)
    Z, V = random.standard_normal((ROWS, 3)), 0.02 * random.standard_normal((ROWS, 3))
    residual = sigma * (random.standard_normal(ROWS) - endogenous * V[:, 0] / 0.02)
    return hausman(rows(Z + V, (Z + V) @ THETA + residual), Z, SIGMA).p_value


def test_size_is_five_percent() -> None:
    """1000 trials: the share below 0.05 has a standard deviation of 0.7 %; the test is exact for Gaussian noise."""
    p = np.array([trial(seed, 0.0) for seed in range(1000)])
    assert np.mean(p < 0.05) == pytest.approx(0.05, abs=0.021)
    assert np.mean(p) == pytest.approx(0.5, abs=0.028)


def test_power_when_residuals_go_along_with_w() -> None:
    p = np.array([trial(seed, 1.0) for seed in range(100)])
    assert np.mean(p < 0.05) > 0.99


def test_units_do_not_matter() -> None:
    random = np.random.default_rng(0)
    Z = random.standard_normal((ROWS, 3))
    W, Y = Z + 0.02 * random.standard_normal(Z.shape), random.standard_normal(ROWS)
    scale = np.array([1e6, 1.0, 1e-6])
    one, other = hausman(rows(W, Y), Z, SIGMA), hausman(rows(W * scale, Y), Z * scale, SIGMA)
    assert other.statistic == pytest.approx(one.statistic, rel=1e-6)
    assert other.freedom == one.freedom == (3, ROWS - 6)


def test_instruments_that_explain_nothing_give_no_answer() -> None:
    random = np.random.default_rng(0)
    found = hausman(rows(random.standard_normal((ROWS, 3)), np.ones(ROWS)), random.standard_normal((ROWS, 3)), SIGMA)
    assert found.consistent is None
    assert "check the control law" in found.message


def test_instruments_that_are_the_regressors_leave_nothing_to_test() -> None:
    W = np.random.default_rng(0).standard_normal((ROWS, 3))
    found = hausman(rows(W, np.ones(ROWS)), W, SIGMA)
    assert found.consistent and found.p_value == 1.0


def test_size_is_five_percent_where_both_noises_rise_with_frequency() -> None:
    """As with a differentiated encoder: V and the residual are loud in the same rows, yet independent. Without the
    spectrum of the residual the test rejects 30 of 100; 500 trials: 0.05 has a deviation of 0.01, three of which, and
    0.01 for the spectrum being estimated."""
    frequency = np.tile(np.linspace(0.1, 10.0, ROWS // 2), 2)
    loud = np.exp(0.35 * frequency) / 5
    rejected = []
    for seed in range(500):
        random = np.random.default_rng(seed)
        Z, V = random.standard_normal((ROWS, 3)), 0.02 * loud[:, None] * random.standard_normal((ROWS, 3))
        residual = np.repeat(SIGMA, ROWS // 2) * loud * random.standard_normal(ROWS)
        made = replace(rows(Z + V, (Z + V) @ THETA + residual), frequency=frequency)
        rejected.append(hausman(made, Z, SIGMA).p_value < 0.05)
    assert np.mean(rejected) == pytest.approx(0.06, abs=0.04)


def test_noise_that_moves_nothing_is_called_harmless() -> None:
    seen = Consistency(5.0, (3, 100), 0.003, 0.99, shift=0.1)
    assert seen.consistent is False
    assert "moves least squares by at most 0.1 deviations" in seen.message
    assert "use iv" in replace(seen, shift=1.0).message
