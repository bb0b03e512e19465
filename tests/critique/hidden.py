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
