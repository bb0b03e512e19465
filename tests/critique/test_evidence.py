"""Evidence against plain least squares: gains, what is known beforehand, the null."""

import numpy as np
import pytest
from arms import NAMES, THETA, make_model
from critique.hidden import KINDS, hidden_log, on, sines
from hypothesis import given
from hypothesis import strategies as st

from chebid.critique.candidates import rank
from chebid.critique.evidence import Evidence, Ground, Held
from chebid.critique.holdout import Holdout
from chebid.critique.stability import stability
from chebid.effects import LIBRARY
from chebid.equations.span import orthonormal
from chebid.estimators import Problem


@pytest.fixture(scope="module")
def ground():
    log = hidden_log(sines(5, 12.0), on(1, lambda p: 0.08 * (p.q[:, 1] - 0.3)), seed=3)
    return Ground(Problem(make_model(), (log,)))


@pytest.fixture(scope="module")
def evidence(ground):
    return Evidence(ground)


def test_the_residual_is_beside_the_model(evidence):
    basis = evidence.model
    np.testing.assert_allclose(basis.T @ basis, np.eye(basis.shape[1]), atol=1e-10)
    np.testing.assert_allclose(basis.T @ evidence.residual, 0, atol=1e-9 * np.linalg.norm(evidence.residual))


@pytest.mark.parametrize("name", ["spring", "viscous_coupling", "viscous_asymmetry", "offset"])
def test_a_gain_is_the_drop_of_the_squared_residual(evidence, name):
    """By refitting model and effect, as anyone would."""
    kind = LIBRARY[name]
    effect = kind.candidates(evidence.trusted, 1, float(evidence.ground.gate[1]))[0]
    judged = evidence.judge(effect)
    y = evidence.system[1]
    W = np.hstack([evidence.model, evidence.columns(effect)])
    after = y - W @ np.linalg.lstsq(W, y)[0]
    assert judged.gain == pytest.approx(np.sum(evidence.residual**2) - np.sum(after**2), rel=1e-6)


def test_an_effect_that_is_in_the_model_gains_nothing(evidence):
    for name in ("viscous", "coulomb"):
        assert evidence.judge(LIBRARY[name](1)).basis.shape[1] == 0


def test_the_noise_is_white_after_whitening(ground):
    """A log with nothing hidden: residuals of deviation 1 at every joint and frequency, within what 200 rows tell."""
    log = hidden_log(sines(5, 12.0), seed=8, colour=0.6)
    clean = Evidence(Ground(Problem(make_model(), (log,))))
    rows = clean.rows
    for joint in range(2):
        for low, high in ((0.0, 0.5), (0.5, 1.0)):
            part = (rows.joint == joint) & (rows.frequency / rows.frequency.max() > low)
            part &= rows.frequency / rows.frequency.max() <= high
            level = np.sqrt(np.mean(clean.residual[: len(rows.Y)][part] ** 2))
            assert level == pytest.approx(1.0, abs=0.2)


def test_parameters_known_exactly_are_held(ground):
    held = Evidence(ground, None, Held(THETA, np.diag((1e-9 * THETA) ** 2)))
    np.testing.assert_allclose(held.theta, THETA, rtol=1e-6)


def test_parameters_hardly_known_are_free(ground, evidence):
    free = Evidence(ground, None, Held(THETA, np.diag((1e3 * np.abs(THETA)) ** 2)))
    np.testing.assert_allclose(free.theta, evidence.theta, rtol=1e-3)
    assert len(free.residual) == len(evidence.residual) + len(NAMES)


def test_the_best_of_all_candidates_on_noise_is_seldom_positive(ground):
    """2 % by design; of 60 draws at most 5 (a chance of 0.3 % for more)."""
    evidence = Evidence(ground)
    start = rank(evidence, KINDS)
    random, alarms = np.random.default_rng(5), 0
    for _ in range(60):
        noise = random.standard_normal(len(evidence.residual))
        noise -= evidence.model @ (evidence.model.T @ noise)
        drawn = Evidence(ground)
        drawn.__dict__.update(evidence.__dict__ | {"residual": noise})
        best = max(
            drawn.worth(c.judged.basis) - (evidence.worth(c.judged.basis) - c.score)
            for c in start.candidates
            if not c.effect.one_way or evidence.columns(c.effect)[:, 0] @ noise > 0  # with a sign that it can have
        )
        alarms += best > 0
    assert alarms <= 5


def test_stability_shares_add_up(evidence):
    top = list(rank(evidence, KINDS).candidates[:6])
    shares = stability(evidence, top)
    assert sum(shares) == pytest.approx(1.0)
    assert shares[0] == max(shares)


def test_a_hold_out_of_the_same_arm_speaks_for_what_is_there(ground, evidence):
    spring = next(c for c in rank(evidence, KINDS).candidates if c.key == ("spring", 1)).effect
    for extra, wanted in ((on(1, lambda p: 0.08 * (p.q[:, 1] - 0.3)), True), (None, False)):
        other = Evidence(Ground(Problem(make_model(), (hidden_log(sines(15, 12.0), extra, seed=5),))), elsewhere=True)
        assert (Holdout(evidence, other).score(spring) > 0) is wanted


@given(st.integers(2, 30), st.integers(1, 6), st.integers(0, 10_000))
def test_orthonormal_spans_the_same(rows, columns, seed):
    W = np.random.default_rng(seed).standard_normal((rows, columns))
    doubled = np.hstack([W, W[:, :1], np.zeros((rows, 1))])
    q = orthonormal(doubled)
    assert q.shape[1] <= min(rows, columns + 1)
    np.testing.assert_allclose(q.T @ q, np.eye(q.shape[1]), atol=1e-9)
    np.testing.assert_allclose(q @ (q.T @ W), W, atol=1e-7)
