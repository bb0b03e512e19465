"""`huber`: Huber's M-estimator by iteratively reweighted least squares, on the rows of `wls`.

Rows whose residual is beyond k robust standard deviations of their joint count less (Janot, Vandanjon, Gautier, IROS
2009; Huber, Robust Statistics, 1981). k = 1.345 keeps 95 % efficiency on Gaussian noise.
"""

from dataclasses import replace

import numpy as np

from chebid.basis import Array
from chebid.equations import Rows
from chebid.errors import NoAnswerError
from chebid.estimators.assemble import assemble
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.settings import HuberSettings, method_settings
from chebid.estimators.weighted import Solution, solve
from chebid.estimators.wls import recipe, wls_rows

_ROUNDS = 50


def huber(problem: Problem) -> Estimate:
    """Estimate robustly. Raises NoAnswerError on rank loss, or when the weights do not settle."""
    settings = method_settings(problem.model, "huber", HuberSettings)
    rows, filters = wls_rows(problem)
    parameters = problem.dynamics.parameters
    root = np.ones(len(rows.Y))
    for _ in range(_ROUNDS):
        found = solve(rows, parameters, root)
        before, root = root, np.sqrt(_weights(rows, rows.Y - rows.W @ found.theta, settings.k))
        if np.max(np.abs(root - before)) < 1e-4:
            break
    else:
        raise NoAnswerError("the Huber weights do not settle", hint="use --method wls, and look at the residuals")
    return assemble(
        problem,
        "huber",
        _corrected(found, rows, root),
        rows,
        {
            "huber": {"k": settings.k, "downweighted": float(np.mean(root < 0.999))},
            "wls": recipe(filters),
            "bandwidth": filters.cutoff,
        },
    )


def _corrected(found: Solution, rows: Rows, root: Array) -> Solution:
    """The covariances of an M-estimator (Huber, 1981, section 7.6).

    Its sensitivity is W^T psi' W, which rows beyond k have no part in, not that of the weighted rows: that is some 10 %
    too small in the deviations on Gaussian noise. And its white covariance is made of psi^2.
    """
    scaled = rows.W / found.sigma[rows.joint][:, None]
    psi = root**2 * (rows.Y - rows.W @ found.theta) / found.sigma[rows.joint]
    inner = root > 1 - 1e-9
    if np.linalg.matrix_rank(scaled[inner]) < scaled.shape[1]:
        return found
    bread = np.linalg.inv(scaled[inner].T @ scaled[inner])
    turn = bread @ (scaled.T @ (scaled * root[:, None] ** 2))
    freedom = len(psi) / max(len(psi) - scaled.shape[1], 1)
    white = bread @ (scaled.T @ (scaled * psi[:, None] ** 2)) @ bread * freedom
    return replace(found, covariance=turn @ found.covariance @ turn.T, white=white)


def _weights(rows: Rows, residual: Array, k: float) -> Array:
    """Huber's weights (R,): 1 within k deviations of the joint, k / |u| beyond."""
    out = np.ones(len(residual))
    for j in range(rows.joints):
        mine = rows.joint == j
        scale = 1.4826 * np.median(np.abs(residual[mine]))
        out[mine] = np.minimum(1.0, k * scale / np.maximum(np.abs(residual[mine]), np.finfo(float).tiny))
    return out
