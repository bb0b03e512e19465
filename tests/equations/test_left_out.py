"""Samples that an effect says to leave out are not used, and the fit is right without them."""

import numpy as np
import pytest
from arms import THETA, TORQUE_NOISE, make_log, make_model, multisine, planar_torque, white

from chebid.estimators import Problem, estimate


def test_clipped_samples_are_left_out():
    """A drive that reports at most its limit: without saying so ZZR1 comes out too small, with it right."""
    path = multisine(1, 20.0, amplitude=0.9)
    tau = planar_torque(path)
    limit = float(np.quantile(np.abs(tau[:, 0]), 0.8))
    tau[:, 0] = np.clip(tau[:, 0], -limit, limit)
    log = make_log(path.t, path.q, tau + white(np.random.default_rng(0), tau.shape, TORQUE_NOISE / 10))
    blind = estimate(Problem(make_model(), (log,)), "poly")
    clipped = {"effect": "saturation", "joint": "q1", "limit": limit - 0.08}
    model = make_model(None, effects=["viscous", "coulomb", clipped])
    seeing = estimate(Problem(model, (log,)), "poly")
    assert abs(blind.theta[0] / THETA[0] - 1) > 0.02
    assert seeing.theta[0] == pytest.approx(THETA[0], abs=4 * seeing.sd[0] + 0.003 * THETA[0])  # samples near the limit
