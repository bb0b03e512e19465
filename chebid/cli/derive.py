"""`chebid derive`."""

from typing import Annotated

import typer

from chebid.cli.common import (
    Bandwidth,
    Basis,
    Degree,
    Fit,
    Force,
    Json,
    LogPath,
    ModelOption,
    Out,
    Plot,
    Rate,
    Signals,
    check_files,
    emit_json,
    save_figure,
    warn,
    write_table,
)
from chebid.cli.project import open_projected
from chebid.errors import UsageError


def derive(
    log: LogPath,
    model: ModelOption = None,
    signal: Signals = None,
    order: Annotated[int, typer.Option("--order", metavar="K", help="Highest derivative.")] = 2,
    fit: Fit = None,
    basis: Basis = "chebyshev",
    rate: Rate = None,
    degree: Degree = None,
    bandwidth: Bandwidth = None,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Positions, velocities, accelerations of a log.

    Column `valid` is false near the ends of a record, where the derivatives cannot be trusted.
    """
    from chebid.report.tables import derivatives

    if not 0 <= order <= 8:
        raise UsageError(f"--order {order} is not between 0 and 8", hint="2 gives accelerations")
    check_files((log, model), out, plot, force)
    source, projected = open_projected(log, model, signal, fit, basis, degree, bandwidth, rate)
    notices = [*source.notices, *(n for _, p in projected for n in p.notices())]
    warn(notices)
    table = derivatives(source, projected, order)
    if out:
        write_table(table, out, force)
    if plot:
        from chebid.report.signals import derivative_figure

        save_figure(derivative_figure(projected, order), plot, force)
    if json:
        emit_json({"columns": {name: table[name].to_numpy() for name in table}, "warnings": [str(n) for n in notices]})
    elif not out:
        typer.echo(table.to_csv(index=False), nl=False)
