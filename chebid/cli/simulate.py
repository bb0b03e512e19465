"""`chebid simulate`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from chebid.cli.common import (
    Force,
    Json,
    Plot,
    check_choice,
    check_files,
    emit_json,
    save_figure,
    say,
    warn,
    write_table,
)
from chebid.errors import Notice, Place, UsageError

if TYPE_CHECKING:
    from chebid.model import Model


def simulate(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="A fitted model file.", show_default=False)],
    trajectory: Annotated[
        Path,
        typer.Argument(metavar="TRAJECTORY", help="t, q1.. and, better, dq1.., ddq1..; or a log.", show_default=False),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="LOG", help="Write the log there.", show_default=False)],
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of noise and encoder zeros.", min=0)] = 0,
    rate: Annotated[
        float | None,
        typer.Option("--rate", metavar="HZ", help="Of the log; that of the trajectory, at most the control's."),
    ] = None,
    duration: Annotated[
        float | None, typer.Option("--duration", metavar="S", help="Of the log; that of the trajectory.")
    ] = None,
    torque_log: Annotated[
        str,
        typer.Option("--torque-log", metavar="HOW", help="average over a log interval, or the latest command."),
    ] = "average",
    noise: Annotated[str, typer.Option("--noise", metavar="KIND", help="white, coloured or none.")] = "white",
    reference: Annotated[bool, typer.Option("--reference", help="Log the commanded r1, r2, ... too.")] = False,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Simulate a closed-loop log of a fitted model.

    Joint PD control with zero-order hold, encoder counts, torque noise, dry friction that sticks. Columns t, q1..,
    tau1.. in SI units.
    """
    from chebid.model import read_model
    from chebid.results import fitted_values
    from chebid.simulate import NOISES, TORQUE_LOGS, Options, read_reference, simulate, simulated_table

    check_choice(torque_log, TORQUE_LOGS, "--torque-log")
    check_choice(noise, NOISES, "--noise")
    _check(rate, duration)
    check_files((model, trajectory), out, plot, force)
    read = read_model(model)
    theta = fitted_values(read)
    options = Options(rate, duration, torque_log, noise)
    log = simulate(read, theta, read_reference(trajectory, read), seed=seed, options=options)
    notices = [*log.notices, *_notices(read)]
    warn(notices)
    write_table(simulated_table(log, reference), out, force)
    if plot:
        from chebid.report.motion import simulation_figure
        from chebid.robots import make_robot

        save_figure(simulation_figure(log, read.joints, make_robot(read).rotary), plot, force)
    if json:
        emit_json(_document(log, read, out, notices))
    else:
        for name, error, part in zip(read.joints, log.largest_error, log.sticks.mean(axis=0), strict=True):
            say(f"{name}: follows to {error:.2g}, sticks {100 * part:.2g} % of the time")
        say(f"next: chebid identify {out} --model MODEL")


def _check(rate: float | None, duration: float | None) -> None:
    for option, value, example in (("--rate", rate, "100"), ("--duration", duration, "20")):
        if value is not None and not 0 < value < 1e7:
            raise UsageError(f"{option} {value} is not a positive number", hint=f"such as {option} {example}")


def _notices(model: "Model") -> list[Notice]:
    """That the log is not in the units and columns of the model's `log:` section."""
    if model.log == type(model.log)():
        return []
    text = "the log is written in SI units with columns t, q1.., tau1..: read it by a model without a log: section"
    return [Notice("si_log", text, Place(file=str(model.path), key="log"))]


def _document(log: Any, model: "Model", out: Path, notices: list[Notice]) -> dict[str, Any]:
    return {
        "log": str(out),
        "joints": list(model.joints),
        "samples": len(log.t),
        "rate": 1 / float(log.t[1]) if len(log.t) > 1 else None,
        "duration": float(log.t[-1]),
        "largest_error": dict(zip(model.joints, log.largest_error, strict=True)),
        "sticks": dict(zip(model.joints, log.sticks.mean(axis=0), strict=True)),
        "warnings": [str(notice) for notice in notices],
    }
