"""`chebid project`."""

import math
from dataclasses import replace
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
    Rate,
    Signals,
    check_files,
    emit_json,
    save_figure,
    warn,
    write_table,
)
from chebid.errors import UsageError

if TYPE_CHECKING:
    from chebid.log import Log
    from chebid.projection import Projection, Setting


def project(
    log: LogPath,
    model: ModelOption = None,
    signal: Signals = None,
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
    """Project signals on polynomials and report the quality.

    -o writes the coefficients: record, signal, window, start and stop in s, degree, value.
    """
    check_files((log, model), out, plot, force)
    source, projected = open_projected(log, model, signal, fit, basis, degree, bandwidth, rate)
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
    rate: float | None,
) -> "tuple[Log, list[tuple[int, Projection]]]":
    """Read a log and project each signal of each record: (record number from 1, projection)."""
    from chebid.basis import family
    from chebid.cli.common import check_choice, with_processing
    from chebid.log import LogSpec, read_log
    from chebid.model import read_model, settings_of
    from chebid.projection import FITS, Setting

    check_choice(fit, FITS, "--fit")
    family(basis)
    if rate is not None and not 0 < rate < math.inf:
        raise UsageError(f"--rate {rate:g} is not above 0", hint="give the sampling rate in Hz")
    if model is None:
        source = read_log(log, LogSpec(rate=rate), signals=signals)
        return source, _projected(source, Setting(fit, basis, degree, bandwidth))
    if signals:
        hint = "leave one of them out: a model names its own columns"
        raise UsageError("both --model and --signal are given", hint=hint)
    read = with_processing(read_model(model), fit, degree, bandwidth)
    source = read_log(log, replace(read.log, rate=rate) if rate else read.log, read.joints)
    p = read.processing
    with settings_of(read):
        return source, _projected(source, Setting(p.fit, basis, p.degree, p.bandwidth))


def _projected(source: "Log", setting: "Setting") -> "list[tuple[int, Projection]]":
    from chebid.motion import project_record

    return [(i, p) for i, record in enumerate(source.records, 1) for p in project_record(source, record, setting)]


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
