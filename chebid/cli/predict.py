"""`chebid predict`."""

from pathlib import Path
from typing import Annotated

import typer

from chebid.cli.common import (
    Force,
    Json,
    LogPath,
    Out,
    Plot,
    check_files,
    emit_json,
    save_figure,
    warn,
    write_table,
)


def predict(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="A fitted model file.", show_default=False)],
    log: LogPath,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Predict the torque along the motion of a log.

    Columns t, tau1, tau2, ...
    """
    from chebid.log import read_logs
    from chebid.model import read_model, settings_of
    from chebid.report.tables import predictions
    from chebid.results import fitted_values, predict_tracks

    check_files((model, log), out, plot, force)
    read = read_model(model)
    theta = fitted_values(read)
    (source,) = read_logs([log], read.log, read.joints, need_torque=False)
    with settings_of(read):
        tracks, torques = predict_tracks(read, source, theta)
    warn(source.notices)
    table = predictions(tracks, torques)
    if out:
        write_table(table, out, force)
    if plot:
        from chebid.report.torques import prediction_figure

        save_figure(prediction_figure(tracks, {model.name: torques}), plot, force)
    if json:
        emit_json(
            {"columns": {name: table[name].to_numpy() for name in table}, "warnings": [str(n) for n in source.notices]}
        )
    elif not out:
        typer.echo(table.to_csv(index=False), nl=False)
