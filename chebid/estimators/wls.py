"""`wls`: weighted least squares on low-pass filtered central differences (Gautier and Poignet, Control Eng. Pract.
9, 2001).

The settings under `methods: wls:` are a recipe: run as written, nothing automatic added, so that published figures
come out again. What the recipe leaves out (no section at all) is taken from the automatic choices of the projection.
"""

from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from chebid.equations import FilterSettings, Rows, filtered_rows
from chebid.errors import InputError, Place
from chebid.estimators.judge import judge
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.weighted import solve


class WlsSettings(BaseModel):
    """`methods: wls:` cutoff in Hz, order of the filter, decimation factor, samples dropped at the start."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
    cutoff: float | None = Field(None, gt=0)
    order: int = Field(4, ge=1, le=12)
    decimate: int | None = Field(None, ge=1)
    drop: int | None = Field(None, ge=0)


def read_settings(problem: Problem) -> WlsSettings:
    """The recipe of the model file. Raises InputError naming the key."""
    given: dict[str, Any] = problem.model.methods.get("wls", {})
    try:
        return WlsSettings.model_validate(given)
    except ValidationError as err:
        first = err.errors(include_url=False)[0]
        key = ".".join(["methods", "wls", *map(str, first["loc"])])
        place = Place(file=str(problem.model.path), key=key, value=first.get("input"))
        raise InputError(first["msg"], hint="known are: cutoff, order, decimate, drop", place=place) from None


def filter_settings(problem: Problem) -> FilterSettings:
    """The recipe completed: with a cut-off given, no gate and no trim but those set under `processing:`."""
    settings, processing = read_settings(problem), problem.model.processing
    recipe = settings.cutoff is not None
    rate = problem.tracks[0].rate
    gated = not recipe or processing.velocity_gate is not None
    cut = max(p.end_length() for p in problem.tracks[0].projections) if not recipe else 0.0
    cutoff = settings.cutoff or min(problem.bandwidth, 0.4 * rate)
    return FilterSettings(
        cutoff=cutoff,
        order=settings.order,
        decimate=settings.decimate or (1 if recipe else max(1, int(0.4 * rate / problem.band.frequency))),
        drop=settings.drop or 0,
        trim=processing.trim if processing.trim is not None else cut,
        gate=tuple(map(float, problem.gate)) if gated else None,
    )


def wls_rows(problem: Problem) -> tuple[Rows, FilterSettings]:
    """The rows of this method."""
    settings = filter_settings(problem)
    records = [record for log in problem.logs for record in log.records]
    return filtered_rows(records, problem.dynamics, settings, problem.model.log.torque_delay), settings


def wls(problem: Problem) -> Estimate:
    """Estimate by filtered differences. Raises NoAnswerError on rank loss or when nothing is left to use."""
    rows, settings = wls_rows(problem)
    dynamics = problem.dynamics
    found = solve(rows, dynamics.parameters)
    recipe = {key: value for key, value in vars(settings).items() if value is not None}
    return Estimate(
        method="wls",
        parameters=dynamics.parameters,
        theta=found.theta,
        covariance=found.covariance,
        white=found.white,
        condition=found.condition,
        residual=judge(problem, rows, found.theta),
        weights=1 / found.sigma,
        record=problem.describe() | {"wls": recipe},
        notices=tuple(problem.notices),
    )
