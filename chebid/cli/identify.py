"""`chebid identify`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from chebid.cli.common import (
    Bandwidth,
    Degree,
    Fit,
    Force,
    Json,
    LogPaths,
    Out,
    Plot,
    check_choice,
    check_files,
    emit_json,
    save_figure,
    warn,
    with_processing,
)
from chebid.errors import InputError, NoAnswerError, Notice, UsageError

if TYPE_CHECKING:
    from chebid.estimators import Estimate, Problem


def identify(
    log: LogPaths,
    model: Annotated[
        Path, typer.Option("--model", "-m", metavar="MODEL", help="Model file (YAML).", show_default=False)
    ],
    method: Annotated[
        str, typer.Option("--method", metavar="NAME", help="poly, wls, huber, iv, ekf or dr; all runs each.")
    ] = "poly",
    fit: Fit = None,
    degree: Degree = None,
    bandwidth: Bandwidth = None,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Identify the parameters of a model from logs.

    Several logs are separate records of the same robot. -o writes the fitted model.
    """
    from chebid.dynamics import make_dynamics
    from chebid.estimators import METHODS, Problem, estimate
    from chebid.log import read_logs
    from chebid.model import read_model, settings_of, write_model
    from chebid.projection import FITS
    from chebid.report.tables import show_estimates
    from chebid.results import estimate_document, fitted_model

    check_choice(method, (*METHODS, "all"), "--method")
    check_choice(fit, FITS, "--fit")
    if method == "all" and out:
        raise UsageError("--method all does not give one model to write", hint="leave out -o, or choose a method")
    check_files((model, *log), out, plot, force, table=False)
    read = with_processing(read_model(model), fit, degree, bandwidth)
    make_dynamics(read)  # what is wrong with the robot or an effect is said before a long log is read
    problem = Problem(read, tuple(read_logs(log, read.log, read.joints)))
    with settings_of(read):
        found = _all(problem) if method == "all" else [estimate(problem, method)]
    warn(notice for one in found for notice in one.notices)
    if out:
        write_model(fitted_model(read, found[0], out), out, force=force)
    if plot:
        from chebid.report.torques import torque_figure

        save_figure(torque_figure(problem, {one.method: one.theta for one in found}), plot, force)
    documents = [estimate_document(one, out) for one in found]
    if json:
        emit_json(documents if method == "all" else documents[0])
    else:
        show_estimates(found)
        _say_next(found, out, log)


def _all(problem: "Problem") -> "list[Estimate]":
    """The estimates of all methods that can be used; of the others, why not."""
    from chebid.estimators import METHODS, estimate

    found, errors = [], []
    for name in METHODS:
        try:
            found.append(estimate(problem, name))
        except (NoAnswerError, InputError) as err:
            errors.append(err)
            warn([Notice("method", f"{name} is left out: {err.message} ({err.hint})")])
    if not found:
        raise errors[0]
    return found


def _say_next(found: "list[Estimate]", out: Path | None, logs: list[Path]) -> None:
    from chebid.cli.common import quoted, say

    if out and len(found) == 1:
        given = " ".join(quoted(path) for path in logs)
        say(f"wrote {out}; next: chebid diagnose {quoted(out)} {given} --holdout LOG (along another motion)")
