"""`Rows`: equations ready for an estimator, with what is needed to judge the estimate."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from chebid.basis import Array

Index = NDArray[np.int64]


@dataclass(frozen=True)
class JointNoise:
    """Sample-level sums of one joint, from which the noise outside the equations' band follows for any theta.

    `gram` (P + 1, P + 1): [W Y]^T [W Y] over all used samples; `samples` their number; `equations` the number of
    independent equations that the rows of this joint amount to (gated rows count in part).
    """

    gram: Array
    samples: int
    equations: float

    def energy(self, theta: Array) -> float:
        """Sum of squared residuals over the samples, in and out of band."""
        v = np.append(-theta, 1.0)
        return float(max(v @ self.gram @ v, 0.0))


@dataclass(frozen=True)
class Rows:
    """W (R, P), Y (R,): eq. 20. `joint` (R,) whose torque a row is; `frequency` (R,) Hz that it represents.

    `block` (R,) numbers stretches of time in order: rows of different blocks are apart in time. `serial`: neighbouring
    rows of a joint follow each other in time (samples), within a `record` (R,); otherwise they are coefficients of
    orthonormal polynomials, whose noise is uncorrelated but may depend on frequency.
    """

    W: Array
    Y: Array
    joint: Index
    frequency: Array
    block: Index
    noise: tuple[JointNoise, ...]
    serial: bool = False
    repeat: float = 1.0  # samples that a row stands for, after decimation
    passed: float = 1.0  # of the band that serial rows can hold, left by the filters of their torque
    record: Index | None = None  # None: all of one

    @property
    def joints(self) -> int:
        return len(self.noise)

    def rms_scale(self, joint: int) -> float:
        """Factor from the norm of a joint's row residual to its rms in torque per sample."""
        return float(np.sqrt(self.repeat / max(self.noise[joint].samples, 1)))


def merge(parts: list[Rows]) -> Rows:
    """Rows of several records as one system; nothing crosses from one to the next."""
    offset = np.cumsum([0] + [int(p.block.max(initial=-1)) + 1 for p in parts])
    noise = tuple(
        JointNoise(sum(n.gram for n in same), sum(n.samples for n in same), sum(n.equations for n in same))
        for same in zip(*(p.noise for p in parts), strict=True)
    )
    return Rows(
        W=np.concatenate([p.W for p in parts]),
        Y=np.concatenate([p.Y for p in parts]),
        joint=np.concatenate([p.joint for p in parts]),
        frequency=np.concatenate([p.frequency for p in parts]),
        block=np.concatenate([p.block + o for p, o in zip(parts, offset, strict=False)]),
        noise=noise,
        serial=parts[0].serial,
        repeat=parts[0].repeat,
        passed=parts[0].passed,
        record=np.repeat(np.arange(len(parts)), [len(p.Y) for p in parts]),
    )
