"""What the studies of the SCARA share: motions, simulated records as logs, priors, estimates on many noise seeds."""

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from chebid.errors import ChebidError
from chebid.estimators import Estimate, Problem, estimate
from chebid.excite import excite
from chebid.excite.limits import make_limits
from chebid.excite.points import Points
from chebid.excite.search import instants
from chebid.log import Log, LogSpec, Record
from chebid.log.average import at_instants
from chebid.model import Model, per_joint
from chebid.results import fitted_values
from chebid.robots import Array
from chebid.simulate import Options, Reference, Simulated, simulate_batch

_STREAM = 99  # of random numbers, for priors: not that of the noise


def find_motion(
    model: Model, settings: dict[str, Any], duration: float, moves: int, seed: int, information: float | None = None
) -> tuple[Array, Array]:
    """A point-to-point motion within the model's limits: its points (M + 1, J) and the durations (M,) s between them.

    `share` of the limits on velocity and acceleration is used, so that the arm, which overshoots, stays within them.
    """
    found = excite(
        _within(model, settings["share"]),
        duration=duration,
        moves=moves,
        seed=seed,
        starts=settings["starts"],
        rate=settings["rate"],
        information=settings["information"] if information is None else information,
    )
    assert found.points is not None and found.durations is not None
    return found.points, found.durations


def sampled(model: Model, points: Array, durations: Array, rate: float) -> pd.DataFrame:
    """Such a motion at `rate` Hz: t, q1.., dq1.., ddq1.. ."""
    family = Points(make_limits(model), float(durations.sum()), len(durations))
    t = instants(family.duration, rate)
    motion = family.motion(np.concatenate([points.ravel(), durations]), t)
    columns = {
        f"{name}{j + 1}": values[:, j]
        for name, values in zip(("q", "dq", "ddq"), motion, strict=True)
        for j in range(values.shape[1])
    }
    return pd.DataFrame({"t": t} | columns).round(9)


def _within(model: Model, share: float) -> Model:
    assert model.limits is not None
    names = ("velocity", "acceleration")
    parts = {
        name: tuple(share * v for v in per_joint(getattr(model.limits, name), len(model.joints))) for name in names
    }
    return model.model_copy(update={"limits": model.limits.model_copy(update=parts)})


def reference(table: pd.DataFrame, joints: int) -> Reference:
    """The motion of such a table."""
    q, dq, ddq = (table[[f"{name}{j + 1}" for j in range(joints)]].to_numpy(float) for name in ("q", "dq", "ddq"))
    return Reference(table["t"].to_numpy(float), q, dq, ddq)


def records(model: Model, motion: Reference, seeds: Sequence[int], **options: Any) -> Iterator[Log]:
    """One closed-loop log of the model for each noise seed, as if it had been read from a file.

    Torques that are logged as means over the log's interval are read as such (`log: torque_average`).
    """
    for seed in seeds:
        chosen = Options(**options)
        (made,) = simulate_batch(model, fitted_values(model), motion, [seed], options=chosen)
        yield as_log(made, model, f"seed {seed}", float(made.t[1]) if chosen.torque_log == "average" else 0.0)


def as_log(made: Simulated, model: Model, name: str, average: float = 0.0) -> Log:
    rows, tau = np.arange(len(made.t)) + 2, at_instants(made.t, made.tau, average)
    return Log(Path(name), "", model.joints, (Record(made.t, made.q, tau, made.reference, rows),), ())


def with_prior(model: Model, spread: float, seed: int) -> Model:
    """The model with the prior of `ekf`: every value off by up to `spread` of itself, uniformly."""
    assert model.fit is not None
    off = 1 + spread * np.random.default_rng([seed, _STREAM]).uniform(-1, 1, len(model.fit.parameters))
    values = {
        name: one.model_copy(update={"value": one.value * float(factor), "sd": None})
        for (name, one), factor in zip(model.fit.parameters.items(), off, strict=True)
    }
    fit = model.fit.model_copy(update={"parameters": values})
    return model.model_copy(update={"fit": fit, "methods": model.methods | {"ekf": {"prior": spread / np.sqrt(3)}}})


def estimates(problem: Problem, methods: Sequence[str]) -> Iterator[tuple[str, Estimate | ChebidError, float]]:
    """Each method's estimate, or why there is none, and the seconds it took."""
    for method in methods:
        start = time.perf_counter()
        try:
            found: Estimate | ChebidError = estimate(problem, method)
        except ChebidError as err:
            found = err
        yield method, found, time.perf_counter() - start


def identifiable(model: Model, rate: float) -> Model:
    """The model of a simulated log at `rate` Hz: its columns and units are those of chebid, its torques means over an
    interval; the reference is logged too.
    """
    columns = tuple(f"r{j + 1}" for j in range(len(model.joints)))
    return model.model_copy(update={"log": LogSpec(reference=columns, torque_average=1 / rate)})
