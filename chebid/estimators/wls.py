"""`wls`: weighted least squares on low-pass filtered central differences (Gautier and Poignet, Control Eng. Pract.
9, 2001).

The settings under `methods: wls:` are a recipe: run as written, nothing automatic added, so that published figures
come out again. What the recipe leaves out (no section at all) is taken from the automatic choices of the projection.
"""

from typing import Any

from chebid.equations import FilterSettings, Rows, filtered_rows
from chebid.estimators.assemble import assemble
from chebid.estimators.problem import Problem
from chebid.estimators.result import Estimate
from chebid.estimators.settings import WlsSettings, method_settings
from chebid.estimators.weighted import solve

# A Butterworth filter bends what lies below its cut-off; the torque passes through the same one, but friction made of
# filtered velocities is not filtered friction. So it lies far above the band of the equations, which both sides are
# filtered to when they are decimated.
_WIDER = 1.5  # times the bandwidth of the projection
_ABOVE = 2.5  # times the band of the equations: bent by less than 1e-3


def filter_settings(problem: Problem) -> FilterSettings:
    """The recipe completed: with a cut-off given, no gate and no trim but those set under `processing:`."""
    settings = method_settings(problem.model, "wls", WlsSettings)
    processing = problem.model.processing
    written = settings.cutoff is not None
    rate = problem.tracks[0].rate
    gated = not written or processing.velocity_gate is not None
    cutoff = settings.cutoff or min(max(_WIDER * problem.bandwidth, _ABOVE * problem.band.frequency), 0.35 * rate)
    # the filter starts from reflected ends: its accelerations are wrong for some three periods of the cut-off
    cut = 0.0 if written else 3 / cutoff
    return FilterSettings(
        cutoff=cutoff,
        order=settings.order,
        decimate=settings.decimate or (1 if written else max(1, int(0.4 * rate / problem.band.frequency))),
        drop=settings.drop or 0,
        trim=processing.trim if processing.trim is not None else cut,
        gate=tuple(map(float, problem.gate)) if gated else None,
        parallel=not written,
    )


def wls_rows(problem: Problem) -> tuple[Rows, FilterSettings]:
    """The rows of this method."""
    settings = filter_settings(problem)
    records = [record for log in problem.logs for record in log.records]
    return filtered_rows(records, problem.dynamics, settings, problem.model.log.torque_delay), settings


def recipe(settings: FilterSettings) -> dict[str, Any]:
    """The settings that were used, for the record."""
    return {key: value for key, value in vars(settings).items() if value is not None}


def wls(problem: Problem) -> Estimate:
    """Estimate by filtered differences. Raises NoAnswerError on rank loss or when nothing is left to use."""
    rows, settings = wls_rows(problem)
    return assemble(
        problem,
        "wls",
        solve(rows, problem.dynamics.parameters),
        rows,
        {"wls": recipe(settings), "bandwidth": settings.cutoff},
    )
