"""Tables: for the terminal (rich) and for files (pandas)."""

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from rich.console import Console
from rich.table import Table

from chebid.basis import Array
from chebid.errors import UsageError
from chebid.estimators import Estimate
from chebid.log import Log
from chebid.motion import Track
from chebid.projection import Projection
from chebid.results import Comparisons, remarks

Projected = Sequence[tuple[int, Projection]]
_WIDE = 10_000  # columns: nothing is cut


def console() -> Console:
    """A line is as long as it is, and left to the terminal to wrap: half a number would be a wrong number."""
    return Console(highlight=False, markup=False, emoji=False, width=_WIDE)


def number(value: float | None, digits: int = 4) -> str:
    """Four significant digits; a dash where there is no number."""
    if value is None or not np.isfinite(value):
        return "-"
    return f"{value:.{digits}g}"


def percent(fraction: float | None) -> str:
    """A fraction as percent, three digits."""
    return "-" if fraction is None else f"{100 * fraction:.3g} %"


def table(title: str | None, heads: Sequence[str], rows: Sequence[Sequence[str]], left: int = 1) -> Table:
    """A table without lines; the first `left` columns are aligned left, the others right."""
    style = "" if os.environ.get("NO_COLOR") else "bold"
    table = Table(title=title, title_justify="left", box=None, pad_edge=False, header_style=style)
    for i, head in enumerate(heads):
        table.add_column(head, justify="left" if i < left else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table


def show_projections(rows: list[dict[str, Any]]) -> None:
    """The quality of each projection."""
    heads = ("signal", "fit", "degree", "windows", "bandwidth Hz", "noise", "left out", "end s", "lag-1")
    body = [
        (
            row["signal"] + (f" (record {row['record']})" if "record" in row else ""),
            row["fit"],
            str(row["degree"]),
            str(row["windows"]),
            number(row["bandwidth"], 3),
            number(row["noise"], 3),
            percent(row["energy_left_out"]),
            number(row["end_length"], 3),
            number(row["lag1_autocorrelation"], 2),
        )
        for row in rows
    ]
    out = console()
    out.print(table(None, heads, body))
    for reason in dict.fromkeys(row["reason"] for row in rows):
        out.print(f"chosen: {reason}")
    out.print(
        "left out: share of the acceleration's energy above the bandwidth; lag-1: autocorrelation of what is left"
    )


def show_estimates(estimates: Sequence[Estimate]) -> None:
    """Parameters, residuals and remarks of each estimate."""
    for estimate in estimates:
        _show_estimate(estimate)
    if len(estimates) > 1:
        out = console()
        out.print("All methods: value and standard deviation")
        out.print(_methods_table(estimates))


def _methods_table(estimates: Sequence[Estimate]) -> Table:
    """Every parameter by every method; `relative` errors are of rows that methods filter in their own ways."""
    body = [
        (p.name, *(f"{number(e.theta[i], 4)} ± {number(e.sd[i], 2)}" for e in estimates), " " + p.unit)
        for i, p in enumerate(estimates[0].parameters)
    ]
    return table(None, ("parameter", *(e.method for e in estimates), "unit"), body)


def _show_estimate(estimate: Estimate) -> None:
    out = console()
    record = estimate.record
    out.print(
        f"{estimate.method}: {_filter(record)}"
        + (f", equations to {number(record['equation_bandwidth'], 3)} Hz" if "equation_bandwidth" in record else "")
        + f", condition number {number(estimate.condition, 4)}"
    )
    out.print(_parameter_table(estimate))
    out.print()
    out.print(_residual_table(estimate))
    for line in remarks(estimate):
        out.print(line)
    out.print()


def _filter(record: Mapping[str, Any]) -> str:
    """What the motion went through: the projections, or the Butterworth filter of a recipe."""
    recipe = record.get("wls")
    if recipe is None:
        return f"bandwidth {number(record['bandwidth'], 3)} Hz"
    every = f", one sample of {recipe['decimate']}" if recipe.get("decimate", 1) > 1 else ""
    return f"Butterworth filter of order {recipe['order']} to {number(recipe['cutoff'], 3)} Hz{every}"


def _parameter_table(estimate: Estimate) -> Table:
    heads = ("parameter", "joint", "value", "sd", "sd %", "eq. 26 %", "unit")
    columns = zip(
        estimate.parameters,
        estimate.theta,
        estimate.sd,
        estimate.relative(estimate.sd),
        estimate.relative(estimate.sd_white),
        strict=True,
    )
    body = [
        (p.name, p.joint or "", number(value, 6), number(sd, 2), number(rel, 2), number(white, 2), " " + p.unit)
        for p, value, sd, rel, white in columns
    ]
    return table(None, heads, body, left=2)


def _residual_table(estimate: Estimate) -> Table:
    heads = ("joint", "rms", "relative", "relative raw", "noise floor", "ratio")
    body = [
        (joint, number(r.rms, 3), percent(r.relative), percent(r.relative_raw), number(r.floor, 3), number(r.ratio, 3))
        for joint, r in estimate.residual.items()
    ]
    return table(None, heads, body)


def show_comparison(results: Comparisons) -> None:
    """Every model on every log."""
    heads = ("model", "log", "joint", "rms", "relative", "relative raw", "noise floor", "ratio")
    models, logs = (
        short_names(entry.model for entry in results.entries),
        short_names(entry.log for entry in results.entries),
    )
    body = [
        (
            models[row["model"]],
            logs[row["log"]],
            row["joint"],
            number(row["rms"], 3),
            percent(row["relative"]),
            percent(row["relative_raw"]),
            number(row["floor"], 3),
            number(row["ratio"], 3),
        )
        for row in results.rows()
    ]
    out = console()
    out.print(table(None, heads, body, left=3))
    for entry in results.entries:
        out.print(f"{models[entry.model]} on {logs[entry.log]}: {percent(entry.overall)} over all joints")
    kinds = {row["floor_kind"] for row in results.rows() if row["floor"] is not None}
    for kind in sorted(kinds):
        out.print(f"noise floor: {kind}")


def short_names(paths: Iterable[str]) -> dict[str, str]:
    """Paths as they are shown: the names of the files, where these differ."""
    different = list(dict.fromkeys(paths))
    names = [Path(path).name for path in different]
    return dict(zip(different, names if len(set(names)) == len(names) else different, strict=True))


def comparison_table(results: Comparisons) -> pd.DataFrame:
    """One row per model, log and joint."""
    return pd.DataFrame(results.rows())


def coefficients(projected: Projected) -> pd.DataFrame:
    """One row per coefficient: record, signal, window, start and stop in s, degree, value."""
    return pd.concat([_coefficients(record, p) for record, p in projected], ignore_index=True)


def _coefficients(record: int, p: Projection) -> pd.DataFrame:
    values = p.series.coefficients[:, :, 0]
    windows, count = values.shape
    layout = p.series.layout
    return pd.DataFrame(
        {
            "record": record,
            "signal": p.name,
            "basis": p.series.family.name,
            "window": np.repeat(np.arange(1, windows + 1), count),
            "start": np.repeat(layout.start, count),
            "stop": np.repeat(layout.stop, count),
            "degree": np.tile(np.arange(count), windows),
            "value": values.ravel(),
        }
    )


def derivatives(source: Log, projected: Projected, order: int) -> pd.DataFrame:
    """t, every signal and its derivatives, and whether they can be trusted, at the log's own instants.

    Raises UsageError when two columns would have one name (signals q1 and dq1).
    """
    _refuse_twins([p.name for i, p in projected if i == 1], order)
    parts = []
    for number_, record in enumerate(source.records, 1):
        mine = [p for i, p in projected if i == number_]
        columns: dict[str, Any] = {"t": record.t}
        if len(source.records) > 1:
            columns["record"] = number_
        for p in mine:
            columns |= {"d" * k + p.name: p.at(record.t, k) for k in range(order + 1)}
        valid = np.all([_valid(p, record.t, order) for p in mine], axis=0)
        parts.append(pd.DataFrame(columns | {"valid": valid}))
    return pd.concat(parts, ignore_index=True)


def _refuse_twins(names: Sequence[str], order: int) -> None:
    taken = {"t", "record", "valid"}
    for name in ("d" * k + name for name in names for k in range(order + 1)):
        if name in taken:
            raise UsageError(
                f"two columns of the result would be called {name!r}",
                hint="name the signals to derive: --signal q1 --signal q2, or give a --model",
            )
        taken.add(name)


def _valid(p: Projection, t: Array, order: int) -> Array:
    cut = p.end_length(order)
    return (t >= p.t[0] + cut) & (t <= p.t[-1] - cut)


def predictions(tracks: Sequence[Track], torques: Sequence[Array]) -> pd.DataFrame:
    """t, tau1, tau2, ... of every record."""
    parts = []
    for number_, (track, torque) in enumerate(zip(tracks, torques, strict=True), 1):
        columns: dict[str, Any] = {"t": track.record.t}
        if len(tracks) > 1:
            columns["record"] = number_
        columns |= {f"tau{j + 1}": torque[:, j] for j in range(torque.shape[1])}
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)
