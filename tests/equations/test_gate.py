"""The gate: below the noise of the velocity and below a share of the speed, nothing is used."""

import numpy as np
import pytest
from arms import make_log, make_model, multisine, paper_moves, planar_torque, white

from chebid.equations import choose_gate, moving
from chebid.equations.gate import fast_enough
from chebid.estimators import Problem


def tracks(path, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    log = make_log(path.t, path.q + white(rng, path.q.shape, noise), planar_torque(path))
    return Problem(make_model(), (log,)).tracks


def test_without_noise_a_share_of_the_fast_speed():
    found = tracks(paper_moves())
    speed = np.abs(found[0].motion.dq[found[0].valid])
    np.testing.assert_allclose(choose_gate(found), 0.02 * np.percentile(speed, 95, axis=0))


@pytest.mark.parametrize("noise", [1e-3, 5e-3])
def test_the_sign_of_the_velocity_is_known_above_the_gate(noise):
    path = multisine(0, 20.0, top=0.8)
    for seed in range(3):
        made = tracks(path, noise, seed)
        used = moving(made[0], choose_gate(made))
        wrong = np.sign(made[0].motion.dq) != np.sign(path.dq)
        assert used.mean() > 0.5
        assert wrong[used].mean() < 1e-3  # four deviations


def test_samples_at_the_gate_are_used():
    (track,) = tracks(paper_moves())
    speed = np.abs(track.motion.dq)
    gate = np.array([speed[300, 0], speed[301, 1]])
    used = moving(track, gate)
    assert used[300, 0] and used[301, 1]
    np.testing.assert_array_equal(used, (speed >= gate) & track.valid[:, None])


def test_where_another_joint_turns_its_direction_is_unknown_too():
    """Coulomb friction of joint 1 on joint 2: the rows of joint 2 leave out the reversals of joint 1 as well."""
    path = paper_moves()
    log = make_log(path.t, path.q, planar_torque(path))
    coupled = {"effect": "coulomb_coupling", "joint": "q2", "source": "q1"}
    problem = Problem(make_model(effects=["coulomb", coupled]), (log,))
    (track,) = problem.tracks
    fast = (np.abs(track.motion.dq) >= problem.gate) & track.valid[:, None]
    used = moving(track, problem.gate)
    np.testing.assert_array_equal(used[:, 0], fast[:, 0])
    np.testing.assert_array_equal(used[:, 1], fast[:, 1] & fast[:, 0])
    assert used[:, 1].sum() < fast[:, 1].sum()
    np.testing.assert_array_equal(moving(Problem(make_model(), (log,)).tracks[0], problem.gate), fast)
    np.testing.assert_array_equal(fast_enough(track.motion.dq, problem.gate, [(0,), (0, 1)]) & fast, used)
