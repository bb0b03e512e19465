"""`chebid project`."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    Signals,
    check_files,
    emit_json,
    save_figure,
    warn,
    write_table,
)

if TYPE_CHECKING:
    from chebid.log import Log
    from chebid.projection import Projection


def project(
    log: LogPath,
    model: ModelOption = None,
    signal: Signals = None,
    fit: Fit = None,
    basis: Basis = "chebyshev",
    degree: Degree = None,
    bandwidth: Bandwidth = None,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Project signals on polynomials and report the quality.

    -o writes the coefficients: record, signal, window, start and stop in s, degree, value.
    """
    check_files((log, model), out, plot, force)
    source, projected = open_projected(log, model, signal, fit, basis, degree, bandwidth)
    rows = [_row(source, number, p) for number, p in projected]
    notices = [*source.notices, *(n for _, p in projected for n in p.notices())]
    warn(notices)
    if out:
        from chebid.report.tables import coefficients

        write_table(coefficients(projected), out, force)
    if plot:
        from chebid.report.signals import projection_figure

        save_figure(projection_figure(projected), plot, force)
    if json:
        emit_json({"signals": rows, "warnings": [str(n) for n in notices]})
    else:
        from chebid.report.tables import show_projections

        show_projections(rows)


def open_projected(
    log: Path,
    model: Path | None,
    signals: list[str] | None,
    fit: str | None,
    basis: str,
    degree: int | None,
    bandwidth: float | None,
) -> "tuple[Log, list[tuple[int, Projection]]]":
    """Read a log and project each signal of each record: (record number from 1, projection)."""
    from chebid.basis import family
    from chebid.cli.common import check_choice, with_processing
    from chebid.log import read_log
    from chebid.model import read_model
    from chebid.motion import project_record
    from chebid.projection import FITS, Setting

    check_choice(fit, FITS, "--fit")
    family(basis)
    setting = Setting(fit, basis, degree, bandwidth)
    if model:
        read = with_processing(read_model(model), fit, degree, bandwidth)
        p = read.processing
        setting = Setting(p.fit, basis, p.degree, p.bandwidth)
        source = read_log(log, read.log, read.joints)
    else:
        source = read_log(log, signals=signals)
    return source, [
        (i, p) for i, record in enumerate(source.records, 1) for p in project_record(source, record, setting)
    ]


def _row(source: "Log", record: int, p: "Projection") -> dict[str, Any]:
    row = {
        "signal": p.name,
        "degree": p.plan.degree,
        "bandwidth": p.plan.bandwidth,
        "fit": p.plan.fit,
        "noise": p.noise,
        "energy_left_out": p.energy_left_out,
        "end_length": p.end_length(),
        "lag1_autocorrelation": p.lag1_autocorrelation,
        "windows": p.operator.layout.count,
        "reason": p.plan.reason,
    }
    return row | {"record": record} if len(source.records) > 1 else row
