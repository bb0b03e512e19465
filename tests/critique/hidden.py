"""Logs of the planar arm with a torque hidden in them, written down by its own formula and not by chebid's effects."""

from collections.abc import Callable

import numpy as np
from arms import THETA, Path3, coloured, make_log, make_model, multisine, planar_torque, point_to_point, white

from chebid.critique import Case, Diagnosis, candidate_kinds, diagnose
from chebid.estimators import Problem, estimate
from chebid.log import Log

NOISE = np.array([0.1, 0.02])  # N.m
COUNT = 1.6e-4  # rad, of the encoders
KINDS, _ = candidate_kinds()
Extra = Callable[[Path3], np.ndarray]


def moves(seed: int, duration: float = 20.0, rate: float = 100.0) -> Path3:
    """Random moves of 1 s between places over the whole range."""
    places = np.random.default_rng(seed).uniform([-1.5, -2.2], [1.5, 2.2], (int(duration) + 1, 2))
    return point_to_point(places, 1.0, rate)


def sines(seed: int, duration: float = 20.0, rate: float = 100.0) -> Path3:
    return multisine(seed, duration, rate, top=1.2, amplitude=0.9)


def trapezoids(seed: int, duration: float = 20.0, rate: float = 250.0) -> Path3:
    """To and fro at constant speed between ramps of constant acceleration, rounded over 60 ms: an industrial motion."""
    random, step = np.random.default_rng(seed), 1e-3
    t = np.arange(round(duration / step) + 1) * step
    ddq = np.zeros((len(t), 2))
    for j, top in enumerate((1.0, 1.5)):
        start, way = 0.2, 1.0
        while True:
            speed, strength = top * random.uniform(0.6, 1.0), 4 * top * random.uniform(0.7, 1.0)
            ramp, cruise = speed / strength, random.uniform(0.3, 0.7)
            stop = start + 2 * ramp + cruise
            if stop > duration - 0.2:
                break
            ddq[(t >= start) & (t < start + ramp), j] = way * strength
            ddq[(t >= stop - ramp) & (t < stop), j] = -way * strength
            start, way = stop + random.uniform(0.1, 0.3), -way
    window = np.hanning(61) / np.hanning(61).sum()
    ddq = np.column_stack([np.convolve(x, window, "same") for x in ddq.T])
    dq = np.cumsum(ddq, axis=0) * step
    q = np.cumsum(dq, axis=0) * step
    every = round(1 / (rate * step))
    return Path3(t[::every], (q - q.mean(axis=0))[::every], dq[::every], ddq[::every])


def on(joint: int, torque: Callable[[Path3], np.ndarray]) -> Extra:
    """A torque (N,) on one joint."""

    def extra(path: Path3) -> np.ndarray:
        out = np.zeros_like(path.q)
        out[:, joint] = torque(path)
        return out

    return extra


def hidden_log(
    path: Path3, extra: Extra | None = None, seed: int = 0, colour: float = 0.0, noise: np.ndarray = NOISE
) -> Log:
    """Encoder counts and noisy torques of the arm, with `extra` in them."""
    rng = np.random.default_rng(seed)
    tau = planar_torque(path, THETA) + (extra(path) if extra else 0.0)
    tau = tau + (coloured(rng, tau.shape, noise, colour) if colour else white(rng, tau.shape, noise))
    return make_log(path.t, np.round(path.q / COUNT) * COUNT, tau)


def diagnosed(log: Log, holdout: Log | None = None, **sections: object) -> Diagnosis:
    """The diagnosis of the arm's model with viscous and Coulomb friction, fitted on the log."""
    problem = Problem(make_model(None, **sections), (log,))
    other = Problem(problem.model, (holdout,)) if holdout else None
    return diagnose(Case(problem, estimate(problem, "poly").theta, holdout=other), KINDS)


def named(d: Diagnosis) -> list[tuple[str, int | None]]:
    """Name and joint of the best candidate of the verdict and of its rivals; empty if nothing is named."""
    if d.verdict.status != "missing" or d.verdict.best is None:
        return []
    return [(one.effect.name, one.effect.joint) for one in (d.verdict.best, *d.verdict.alternatives)]
