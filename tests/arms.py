"""Arms whose motion and torque are known exactly: analytic motions, inverse dynamics by a second road, noise on top.

Nothing of `chebid` computes a torque here. The SCARA is a planar arm of two links with masses, lengths and inertias,
its torques come from a recursive Newton-Euler written link by link (`planar_torque`), and only the conversion of its
physical constants to base parameters is that of the paper (eq. 19).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from chebid.log import Log, Record
from chebid.model import Model

JOINTS = ("q1", "q2")
# eq. 19 in the order of Dynamics.parameters: ZZR1 Fv1 Fs1 | ZZ2 LMX2 LMY2 Fv2 Fs2 (facts.md, section 3)
THETA = np.array([3.45, 0.03, 0.8, 0.061, 0.124, 0.008, 0.012, 0.13])
NAMES = ("ZZR1", "Fv1", "Fs1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2")
SCARA = {"robot": {"type": "scara"}, "joints": list(JOINTS), "effects": ["viscous", "coulomb"]}
TORQUE_NOISE = np.array([0.25, 0.025])  # N.m, of the two joints: they differ by ten, as in the paper


@dataclass(frozen=True)
class Path3:
    """A motion known in closed form: t (N,) s; q, dq, ddq (N, J)."""

    t: np.ndarray
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray


def multisine(
    seed: int = 0,
    duration: float = 10.0,
    rate: float = 100.0,
    joints: int = 2,
    top: float = 1.5,
    amplitude: float = 0.5,
) -> Path3:
    """Eight sines a joint of arbitrary frequencies up to `top` Hz, so that nothing repeats within the record."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(duration * rate) + 1) / rate
    frequency = rng.uniform(0.1, top, (8, joints))
    phase, size = rng.uniform(0, 2 * np.pi, (2, 8, joints))
    size = amplitude * (0.5 + size / (2 * np.pi)) / (1 + frequency)
    return sines(t, frequency, size, phase)


def periodic(period: float, repeats: float, rate: float = 100.0, seed: int = 0, joints: int = 2) -> Path3:
    """A motion of six harmonics that comes again after `period` s."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(period * repeats * rate) + 1) / rate
    frequency = np.arange(1, 7)[:, None] * np.ones(joints) / period
    return sines(t, frequency, rng.uniform(0.1, 0.3, (6, joints)), rng.uniform(0, 2 * np.pi, (6, joints)))


def sines(t: np.ndarray, frequency: np.ndarray, size: np.ndarray, phase: np.ndarray) -> Path3:
    w = 2 * np.pi * frequency
    angle = t[:, None, None] * w + phase
    q = np.sum(size * np.sin(angle), axis=1)
    return Path3(t, q, np.sum(size * w * np.cos(angle), axis=1), -np.sum(size * w**2 * np.sin(angle), axis=1))


def point_to_point(places: Sequence[Sequence[float]], move: float = 0.9, rate: float = 100.0) -> Path3:
    """Fifth-order polynomial moves between places (rad), each of `move` s, at rest in between (paper, section 3.3)."""
    corners = np.asarray(places, dtype=float)
    count = len(corners) - 1
    t = np.arange(round(count * move * rate) + 1) / rate
    leg = np.minimum((t / move).astype(int), count - 1)
    u = (t / move - leg)[:, None]
    start, step = corners[leg], np.diff(corners, axis=0)[leg]
    q = start + step * u**3 * (10 - 15 * u + 6 * u**2)
    dq = step / move * 30 * u**2 * (1 - u) ** 2
    return Path3(t, q, dq, step / move**2 * 60 * u * (1 - u) * (1 - 2 * u))


def paper_moves(seed: int = 3, moves: int = 9, move: float = 0.9, rate: float = 100.0) -> Path3:
    """Nine moves between random places, as in the paper's experiment."""
    rng = np.random.default_rng(seed)
    return point_to_point(rng.uniform([-1.5, -2.2], [1.5, 2.2], (moves + 1, 2)), move, rate)


def planar_torque(path: Path3, theta: np.ndarray = THETA) -> np.ndarray:
    """(N, 2) torque of a planar 2R arm by a recursive Newton-Euler, sample by sample, plus viscous and dry friction.

    Links with L = 1: body 2 has first moments (LMX2, LMY2) and inertia ZZ2 about its joint; body 1 is what is left of
    ZZR1 = ZZ1 + M2 L^2. The mass of body 2 cancels and is set to 1.
    """
    zzr1, fv1, fs1, zz2, lmx2, lmy2, fv2, fs2 = theta
    m2, length = 1.0, 1.0
    zz1 = zzr1 - m2 * length**2
    out = np.empty_like(path.q)
    for i, (q, dq, ddq) in enumerate(zip(path.q, path.dq, path.ddq, strict=True)):
        # outward: rotation rate and acceleration of each link frame, acceleration of its origin
        w1, e1 = dq[0], ddq[0]
        w2, e2 = dq[0] + dq[1], ddq[0] + ddq[1]
        tip = np.array([-(w1**2) * length, e1 * length])  # of joint 2, in the frame of link 1
        c, s = np.cos(q[1]), np.sin(q[1])
        a2 = np.array([c * tip[0] + s * tip[1], -s * tip[0] + c * tip[1]])
        # inward: force and moment of link 2 about joint 2, from first moments m r = (lmx2, lmy2) / length
        mr = np.array([lmx2, lmy2]) / length
        turned = np.array([-mr[1], mr[0]])
        force2 = m2 * a2 + e2 * turned - w2**2 * mr
        moment2 = zz2 * e2 + mr[0] * a2[1] - mr[1] * a2[0]
        force_in_1 = np.array([c * force2[0] - s * force2[1], s * force2[0] + c * force2[1]])
        moment1 = zz1 * e1 + moment2 + length * force_in_1[1]
        out[i] = moment1, moment2
    friction = np.array([fv1, fv2]) * path.dq + np.array([fs1, fs2]) * np.sign(path.dq)
    return out + friction


def white(rng: np.random.Generator, shape: tuple[int, ...], sd: np.ndarray | float) -> np.ndarray:
    return rng.standard_normal(shape) * sd


def coloured(rng: np.random.Generator, shape: tuple[int, ...], sd: np.ndarray | float, rho: float = 0.9) -> np.ndarray:
    """AR(1) noise of standard deviation sd, stationary from the first sample."""
    start = 200
    e = rng.standard_normal((shape[0] + start, *shape[1:])) * np.sqrt(1 - rho**2)
    return lfilter([1.0], [1.0, -rho], e, axis=0)[start:] * sd


def make_log(t: np.ndarray, q: np.ndarray, tau: np.ndarray | None, names: Sequence[str] = JOINTS) -> Log:
    """A log of one record, as if it had been read."""
    return join_records([(t, q, tau)], names)


def join_records(parts: Sequence[tuple[np.ndarray, np.ndarray, np.ndarray | None]], names: Sequence[str]) -> Log:
    records, first = [], 2
    for t, q, tau in parts:
        records.append(Record(t, q, tau, None, np.arange(first, first + len(t))))
        first += len(t)
    return Log(Path("log.csv"), "0" * 64, tuple(names), tuple(records), ())


def make_model(data: dict | None = None, **sections: object) -> Model:
    """A model from the SCARA's data with further sections."""
    return Model.model_validate({**(data or SCARA), **sections})


def write_csv(path: Path, **columns: np.ndarray) -> Path:
    names = list(columns)
    body = np.column_stack([columns[name] for name in names])
    np.savetxt(path, body, "%.12g", ",", header=",".join(names), comments="")
    return path


def write_log(path: Path, t: np.ndarray, q: np.ndarray, tau: np.ndarray | None = None) -> Path:
    columns = {"t": t} | {f"q{j + 1}": q[:, j] for j in range(q.shape[1])}
    if tau is not None:
        columns |= {f"tau{j + 1}": tau[:, j] for j in range(tau.shape[1])}
    return write_csv(path, **columns)
