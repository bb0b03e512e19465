"""Weighted least squares on rows (eq. 20-25), one weight per joint, with an honest covariance.

Each joint's rows are divided by the standard deviation of its residual, iterated: torque noises differ by a factor
of ten between joints, and unweighted the small joint's parameters come out several times worse.
"""

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.stats import norm
from scipy.stats import t as student

from chebid.basis import Array
from chebid.equations import Rows
from chebid.equations.rows import Index
from chebid.errors import NoAnswerError
from chebid.estimators.enough import lost_rank_by, shortage, too_few
from chebid.estimators.spectrum import Block, spectra
from chebid.robots import Parameter

_RANK = 1e-9  # singular values of the column-scaled W below this share of the largest are zero
_ROUNDS = 20
_QUANTILE = 0.975  # of intervals of 95 %


@dataclass(frozen=True)
class Solution:
    """theta (P,), honest and white covariances (P, P), residual deviation per joint (J,), condition of W."""

    theta: Array
    covariance: Array
    white: Array
    sigma: Array
    condition: float


def solve(rows: Rows, parameters: tuple[Parameter, ...], extra: Array | None = None) -> Solution:
    """Estimate theta; `extra` (R,) are further weights per row (robust ones).

    Raises NoAnswerError on rank loss, and for a joint with no more equations than parameters.
    """
    if short := shortage(rows, parameters):
        try:
            _least_squares(rows.W, rows.Y, parameters)
        except NoAnswerError as err:
            raise lost_rank_by(short, err) from None
        raise too_few(short)
    extra = np.ones(len(rows.Y)) if extra is None else extra
    sigma = np.ones(rows.joints)
    for _ in range(_ROUNDS):
        weight = extra / sigma[rows.joint]
        theta, inverse = _least_squares(rows.W * weight[:, None], rows.Y * weight, parameters)
        before, sigma = sigma, _sigma(rows, theta, inverse, weight, extra)
        if np.allclose(before, sigma, rtol=1e-8, atol=0):
            break
    weight = extra / sigma[rows.joint]
    theta, inverse = _least_squares(rows.W * weight[:, None], rows.Y * weight, parameters)
    honest = sandwich(rows, rows.W, inverse, weight)
    return Solution(theta, honest, inverse, sigma, float(np.linalg.cond(rows.W)))


def solve_instrumental(rows: Rows, Z: Array, start: Solution, parameters: tuple[Parameter, ...]) -> Solution:
    """theta = (Z^T W)^-1 Z^T Y with instruments Z (R, P), weighted by the deviations of an earlier solution.

    White covariance sigma^2 (Z^T W)^-1 Z^T Z (W^T Z)^-1. Raises NoAnswerError when Z^T W has lost rank.
    """
    weight = 1 / start.sigma[rows.joint]
    product = (Z * weight[:, None]).T @ (rows.W * weight[:, None])
    scale = np.sqrt(np.maximum(np.abs(np.diag(product)), np.finfo(float).tiny))
    _, singular, v = np.linalg.svd(product / np.outer(scale, scale))
    if singular[-1] <= _RANK * singular[0]:
        raise _rank_loss(v[-1], parameters)
    bread = np.asarray(np.linalg.inv(product), dtype=np.float64)
    theta = bread @ ((Z * weight[:, None]).T @ (rows.Y * weight))
    white = bread @ ((Z * weight[:, None]).T @ (Z * weight[:, None])) @ bread.T
    return Solution(theta, sandwich(rows, Z, bread, weight), white, start.sigma, start.condition)


def _least_squares(W: Array, Y: Array, parameters: tuple[Parameter, ...]) -> tuple[Array, Array]:
    """theta = W^+ Y (eq. 21, 22) by QR of the scaled columns, and (W^T W)^-1."""
    scale = np.linalg.norm(W, axis=0)
    scale[scale == 0] = 1.0
    q, r = np.linalg.qr(W / scale)
    _, singular, v = np.linalg.svd(r)
    if len(singular) < W.shape[1] or singular[-1] <= _RANK * singular[0]:
        raise _rank_loss(v[-1], parameters)
    inverse = np.linalg.inv(r)
    return (inverse @ (q.T @ Y)) / scale, (inverse @ inverse.T) / np.outer(scale, scale)


def _rank_loss(direction: Array, parameters: tuple[Parameter, ...]) -> NoAnswerError:
    involved = [
        p.name for p, part in zip(parameters, direction, strict=True) if abs(part) > 0.05 * np.max(np.abs(direction))
    ]
    if len(involved) == 1:
        text = f"the data say nothing about {involved[0]}"
    else:
        text = f"only combinations of {', '.join(involved)} show in the data, not each of them"
    return NoAnswerError(
        f"the observation matrix has lost rank: {text}",
        hint="record a motion that excites them (chebid excite), or take one of them out of the model",
    )


def _sigma(rows: Rows, theta: Array, inverse: Array, weight: Array, extra: Array) -> Array:
    """Residual standard deviation (J,) per equation, each joint's share of the parameters counted off."""
    residual = (rows.Y - rows.W @ theta) * extra
    leverage = np.einsum("rp,pq,rq->r", rows.W, inverse, rows.W, optimize=True) * weight**2
    out = np.empty(rows.joints)
    for j in range(rows.joints):
        mine = rows.joint == j
        freedom = max(rows.noise[j].equations - leverage[mine].sum(), 1.0)
        out[j] = np.sqrt(np.sum(residual[mine] ** 2) / freedom)
    smallest = 1e-12 * np.linalg.norm(rows.Y) / np.sqrt(len(rows.Y))
    return np.maximum(out, max(smallest, np.finfo(float).tiny))


def sandwich(rows: Rows, Z: Array, bread: Array, weight: Array) -> Array:
    """Honest covariance (P, P) of theta = bread Z^T Y: the residual has the variance, joint by joint and frequency by
    frequency, that it shows.

    Each deviation is widened by Student's quantile over the normal one: its own freedom follows from how surely the
    variances are known that it is made of (Satterthwaite, Biometrics Bulletin 2, 1946).
    """
    theta = bread @ ((Z * weight[:, None]).T @ (rows.Y * weight))
    blocks = [_block(rows, Z @ bread.T, theta, weight, rows.joint == j) for j in range(rows.joints)]
    covariance, doubt = np.zeros((len(theta),) * 2), np.zeros(len(theta))
    for block, noise in zip(blocks, spectra(blocks), strict=True):
        covariance += (block.influence * noise.variance[:, None]).T @ block.influence
        doubt += np.sum(((block.influence**2 * noise.variance[:, None]).T @ noise.unsure) ** 2, axis=1)
    freedom = 2 * np.diag(covariance) ** 2 / np.maximum(doubt, np.finfo(float).tiny)
    wider = student.ppf(_QUANTILE, np.maximum(freedom, 2.0)) / norm.ppf(_QUANTILE)
    return covariance * np.outer(wider, wider)


def _block(rows: Rows, influence: Array, theta: Array, weight: Array, mine: NDArray[np.bool_]) -> Block:
    """The weighted rows of one joint, by frequency."""
    residual = rows.Y[mine] - rows.W[mine] @ theta
    columns = np.column_stack([rows.W[mine], influence[mine], residual]) * weight[mine, None]
    frequency = rows.frequency[mine]
    if rows.serial:
        columns, frequency = _by_frequency(columns, rows.passed, None if rows.record is None else rows.record[mine])
    count = rows.W.shape[1]
    return Block(columns[:, :count], columns[:, count:-1], columns[:, -1], frequency)


def _by_frequency(columns: Array, passed: float, record: Index | None = None) -> tuple[Array, Array]:
    """Samples in a row (R, K) as their cosine transform, which leaves least squares as it is, and its frequencies.

    Of these only those that filters have `passed`: what is above has no noise, and stands for no equation. Every
    `record` (R,) is transformed by itself: nothing connects one to the next.
    """
    if record is not None and len(numbers := np.unique(record)) > 1:
        parts = [_by_frequency(columns[record == number], passed) for number in numbers]
        return np.concatenate([part for part, _ in parts]), np.concatenate([frequency for _, frequency in parts])
    count = len(columns)
    kept = max(int(passed * count), columns.shape[1], 1)
    return scipy.fft.dct(columns, axis=0, norm="ortho")[:kept], np.arange(1, count + 1)[:kept] / count
