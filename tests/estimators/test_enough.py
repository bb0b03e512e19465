"""Short records, several records, and what a fit remembers of its trim."""

import numpy as np
import pytest
from arms import TORQUE_NOISE, join_records, make_log, make_model, multisine, planar_torque, white

from chebid.equations import JointNoise, Rows
from chebid.errors import NoAnswerError
from chebid.estimators import Problem, estimate
from chebid.estimators.weighted import solve
from chebid.estimators.wls import wls_rows
from chebid.robots import Parameter


def rows_of(W, Y, joint, record=None):
    noise = tuple(JointNoise(np.zeros((W.shape[1] + 1,) * 2), n, float(n)) for n in np.bincount(joint).tolist())
    return Rows(
        W, Y, joint, np.ones(len(Y)), np.zeros(len(Y), dtype=int), noise, serial=True, passed=0.5, record=record
    )


NAMED = tuple(Parameter(f"p{i}", joint, "1") for i, joint in enumerate(("left", "left", "right", "right")))


def test_a_joint_with_as_many_equations_as_parameters_is_refused():
    """It would be fitted exactly, and its weight beyond all bounds; the other joint has plenty and does not help."""
    rng = np.random.default_rng(0)
    for count, refused in ((1, True), (2, True), (3, False)):
        joint = np.repeat([0, 1], [40, count])
        W = rng.standard_normal((len(joint), 4))
        rows = rows_of(W, W @ np.ones(4) + 0.1 * rng.standard_normal(len(joint)), joint)
        if refused:
            with pytest.raises(NoAnswerError, match=f"joint right has {count} independent equations for its 2 param"):
                solve(rows, NAMED)
        else:
            assert np.isfinite(solve(rows, NAMED).theta).all()


def test_parameters_that_do_not_act_need_no_equations():
    rng = np.random.default_rng(0)
    joint = np.repeat([0, 1], [40, 2])
    W = rng.standard_normal((42, 4))
    W[joint == 1, 2] = 0.0
    assert np.isfinite(solve(rows_of(W, rng.standard_normal(42), joint), NAMED).theta).all()


def test_nothing_is_correlated_across_records():
    """The honest covariance of two records is that of the same two the other way round; that of one long one is not."""
    rng = np.random.default_rng(1)
    W, noise = np.abs(rng.standard_normal((200, 4))) + 1.0, np.repeat([1.0, -1.0], 100) + 0.1 * rng.standard_normal(200)
    joint, record = np.zeros(200, dtype=int), np.repeat([0, 1], 100)
    turned = np.concatenate([np.arange(100, 200), np.arange(100)])
    apart = solve(rows_of(W, noise, joint, record), NAMED).covariance
    swapped = solve(rows_of(W[turned], noise[turned], joint, record), NAMED).covariance
    whole = solve(rows_of(W, noise, joint), NAMED).covariance
    np.testing.assert_allclose(apart, swapped, rtol=1e-9)  # sums in another order
    assert not np.allclose(apart, whole, rtol=1e-3)


def test_filtered_rows_know_their_records():
    paths = [multisine(seed, 8.0) for seed in (0, 1)]
    log = join_records([(p.t, p.q, planar_torque(p)) for p in paths], ("q1", "q2"))
    rows, _ = wls_rows(Problem(make_model(methods={"wls": {"cutoff": 5.0}}), (log,)))
    assert np.unique(rows.record).tolist() == [0, 1]
    for number in (0, 1):
        assert np.count_nonzero(rows.record == number) == len(paths[number].t) * 2


def noisy(seed, duration):
    path, rng = multisine(seed, duration), np.random.default_rng(seed)
    tau = planar_torque(path) + white(rng, path.q.shape, TORQUE_NOISE)
    return make_log(path.t, path.q + white(rng, path.q.shape, 1e-4), tau)


def test_the_trim_is_remembered_and_taken_on_other_logs():
    """The automatic trim stands in the record; another log loses as much at its ends, or more when it needs more."""
    problem = Problem(make_model(), (noisy(0, 12.0),))
    found = estimate(problem, "poly")
    assert found.record["trim"] == problem.tracks[0].trim > 0
    inside = problem.tracks[0].motion.t[problem.tracks[0].valid]
    assert inside[0] == pytest.approx(found.record["trim"], abs=0.011)  # a step
    for trim in (found.record["trim"], 1.5):
        other = Problem(make_model(), (noisy(1, 12.0),), found.record | {"trim": trim})
        alone = Problem(make_model(), other.logs)
        assert other.tracks[0].trim == max(trim, alone.tracks[0].trim)
    set_by_hand = Problem(make_model(processing={"trim": 0.7}), (noisy(0, 12.0),))
    assert estimate(set_by_hand, "poly").record["trim"] == 0.7
