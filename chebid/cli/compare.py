"""`chebid compare`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from chebid.cli.common import (
    Force,
    Json,
    Out,
    Plot,
    check_files,
    emit_json,
    quoted,
    save_figure,
    say,
    warn,
    write_table,
)
from chebid.errors import UsageError

if TYPE_CHECKING:
    from chebid.results import Comparisons

_FAILS = 1.5  # times the noise floor: an error that wants an explanation


def compare(
    files: Annotated[
        list[Path],
        typer.Argument(metavar="MODEL... LOG...", help="Fitted models (.yaml) and logs.", show_default=False),
    ],
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Compare measured with predicted torque.

    Error, noise floor and their ratio, for every model on every log.
    """
    from chebid.model import read_model
    from chebid.report.tables import comparison_table, show_comparison
    from chebid.results import compare_models

    models = [path for path in files if path.suffix.lower() in (".yaml", ".yml")]
    logs = [path for path in files if path not in models]
    if not models or not logs:
        raise UsageError(
            "no log is given" if models else "no model (.yaml) is given",
            hint="name at least one model (.yaml) and one log: chebid compare MODEL LOG",
        )
    check_files(files, out, plot, force)
    results = compare_models([read_model(path) for path in models], logs)
    warn(results.notices)
    if out:
        write_table(comparison_table(results), out, force)
    if plot:
        from chebid.report.torques import comparison_figure

        save_figure(comparison_figure(results), plot, force)
    if json:
        emit_json(results.document())
    else:
        show_comparison(results)
        if len(models) == 1:
            _say_next(results, models[0], logs)


def _say_next(results: "Comparisons", model: Path, logs: list[Path]) -> None:
    """Where the model fails worst, and the command that asks why."""
    found = [
        (residual.ratio, joint, log)
        for entry, log in zip(results.entries, logs, strict=True)
        for joint, residual in entry.residual.items()
        if residual.ratio is not None
    ]
    ratio, joint, log = max(found, default=(0.0, "", model), key=lambda one: one[0])
    if ratio > _FAILS:
        worst = f"{joint} on {log}: {ratio:.2g} times the noise floor"
        say(f"{worst}; next: chebid diagnose {quoted(model)} {quoted(log)}")
