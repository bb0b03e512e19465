"""`ekf` and `dr`: against what is known of the filter, the differentiator, and of motions without noise."""

from dataclasses import replace

import numpy as np
import pytest
from arms import NAMES, THETA, TORQUE_NOISE, make_log, make_model, multisine, planar_torque, white

from chebid.errors import InputError
from chebid.estimators import Estimate, Problem, estimate
from chebid.estimators.dr import differentiate

PATH = multisine(1, 20.0)
OFF = np.array([0.8, 1.25, 0.85, 1.2, 0.9, 1.15, 0.8, 1.2])


def filtered(prior: float, noise: float, seed: int = 0, off: np.ndarray = OFF) -> Estimate:
    """`ekf` on a log with a prior of OFF times the truth; `noise` as a share of that of the paper."""
    rng = np.random.default_rng(seed)
    q = PATH.q + white(rng, PATH.q.shape, 5e-5)
    tau = planar_torque(PATH) + white(rng, PATH.q.shape, noise * TORQUE_NOISE)
    values = {name: {"value": float(value), "unit": "1"} for name, value in zip(NAMES, off * THETA, strict=True)}
    fit = {"method": "poly", "parameters": values}
    model = make_model(fit=fit, methods={"ekf": {"prior": prior}})
    return estimate(Problem(model, (make_log(PATH.t, q, tau),)), "ekf")


def test_a_wide_prior_is_forgotten_and_a_narrow_one_kept():
    """Inertias to 0.3 % with a torque noise of a hundredth, friction to 5 %: reversals hold both directions."""
    wide = filtered(1.0, 0.01)
    error = wide.theta / THETA - 1
    assert np.all(np.abs(error[[0, 3, 4]]) < 3e-3), error.round(4)
    assert np.all(np.abs(error[[2, 7]]) < 0.05), error.round(4)
    narrow = filtered(1e-7, 0.01)
    np.testing.assert_allclose(narrow.theta, OFF * THETA, rtol=1e-3)
    assert np.all(narrow.sd_white <= 1.001e-7 * OFF * THETA)


def test_it_is_not_biased_by_the_length_of_its_steps():
    """Regression: midpoint steps of 10 ms took LMX2 down by a deviation."""
    found = [filtered(0.3, 1.0, seed) for seed in range(6)]
    bias = np.mean([one.theta - THETA for one in found], axis=0)
    size = np.mean([one.sd for one in found], axis=0)
    assert np.all(np.abs(bias[[0, 3, 4]]) < 1.5 * size[[0, 3, 4]]), (bias / size).round(2)


def test_the_prior_narrows_the_interval():
    both = filtered(0.05, 1.0)
    assert np.all(both.sd_white <= 0.05 * OFF * THETA * 1.001)


def test_without_a_prior_it_says_what_to_do():
    model = make_model(methods={"ekf": {"prior": 0.3}})
    with pytest.raises(InputError, match="needs prior values"):
        estimate(Problem(model, (make_log(PATH.t, PATH.q, planar_torque(PATH)),)), "ekf")


def test_the_differentiator_follows_a_sine():
    """Far above the noise, L above the fourth derivative: the mean of the passes is right to some per cent."""
    t = np.linspace(0, 5, 5001)
    w = 2 * np.pi
    x = np.column_stack([np.sin(w * t), 0.5 * np.cos(w * t)])
    _, dq, ddq = differentiate(x, float(t[1]), np.full(x.shape, 2.5 * w**4))
    inner = slice(1000, -1000)
    np.testing.assert_allclose(dq[inner, 0], w * np.cos(w * t[inner]), atol=2e-3 * w)
    assert np.sqrt(np.mean((ddq[inner, 0] + w**2 * x[inner, 0]) ** 2)) < 0.05 * w**2


def test_the_interval_of_dr_holds_the_truth_and_the_noise_of_the_torque():
    """Its rows hold chatter, so that its deviation is not made of them."""
    rng = np.random.default_rng(3)
    q, tau = PATH.q + white(rng, PATH.q.shape, 5e-5), planar_torque(PATH) + white(rng, PATH.q.shape, TORQUE_NOISE)
    found = estimate(Problem(make_model(), (make_log(PATH.t, q, tau),)), "dr")
    plain = estimate(Problem(make_model(), (make_log(PATH.t, q, tau),)), "poly")
    away = np.abs(found.theta - THETA) / found.sd
    assert np.all(away < 4), away.round(1)
    assert np.all(found.sd > 0.99 * plain.sd)  # the torque's noise is in it, and the scatter of the differentiator
    assert replace(found, theta=THETA).relative(found.sd)[0] < 0.5  # per cent
