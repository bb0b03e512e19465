"""What all commands share: options, output, warnings."""

import gzip
import json
import math
import os
import shlex
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from chebid.errors import Notice, Place, UsageError
from chebid.files import check_outputs, write_with

if TYPE_CHECKING:
    import pandas as pd

    from chebid.model import Model

LogPath = Annotated[
    Path, typer.Argument(metavar="LOG", help="CSV, TSV, Parquet, MAT, NPZ or HDF5.", show_default=False)
]
LogPaths = Annotated[
    list[Path], typer.Argument(metavar="LOG...", help="CSV, TSV, Parquet, MAT, NPZ or HDF5.", show_default=False)
]
ModelOption = Annotated[Path | None, typer.Option("--model", "-m", metavar="MODEL", help="Model file (YAML).")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout.")]
Out = Annotated[Path | None, typer.Option("--out", "-o", metavar="FILE", help="Write the result there.")]
Plot = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw a figure (png, svg or pdf).")]
Force = Annotated[bool, typer.Option("--force", help="Replace existing output files.")]
Fit = Annotated[str | None, typer.Option("--fit", metavar="FIT", help="lsq, quadrature or smooth.")]
Basis = Annotated[str, typer.Option("--basis", metavar="BASIS", help="chebyshev, chebyshev2 or legendre.")]
Degree = Annotated[
    int | None, typer.Option("--degree", "-n", metavar="N", help="Degree on the whole record, as in the paper.")
]
Bandwidth = Annotated[
    float | None, typer.Option("--bandwidth", "-b", metavar="HZ", help="Pass everything up to this frequency.")
]
Rate = Annotated[
    float | None, typer.Option("--rate", metavar="HZ", help="Sampling rate of a log without a time column.")
]
Seed = Annotated[int, typer.Option("--seed", metavar="N", help="Of everything random.", min=0)]
Signals = Annotated[
    list[str] | None, typer.Option("--signal", "-s", metavar="NAME", help="Column to use; repeat for several.")
]


def emit_json(document: Any) -> None:
    """Print one JSON document; NaN and infinity become null."""
    plain = "utf" not in (sys.stdout.encoding or "utf-8").lower()
    sys.stdout.write(json.dumps(_plain(document), indent=1, ensure_ascii=plain, allow_nan=False) + "\n")


def _plain(value: Any) -> Any:
    """Numpy values and arrays as Python ones, paths as text, non-finite numbers as None."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, str | bool | int | None):
        return value
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return str(value)


def warn(notices: Iterable[Notice]) -> None:
    """Warnings to stderr, one line each, each once."""
    if os.environ.get("CHEBID_QUIET"):
        return
    for text in dict.fromkeys(str(notice) for notice in notices):
        sys.stderr.write(f"warning: {text}\n")


def quoted(path: Path) -> str:
    """A path as it must be typed."""
    return shlex.quote(str(path))


def held_out(logs: Sequence[Path] | None) -> str:
    """Hold-out logs as options to be typed, each with a space before it."""
    return "".join(f" --holdout {quoted(path)}" for path in logs or [])


def say(text: str) -> None:
    """A remark on stderr."""
    if not os.environ.get("CHEBID_QUIET"):
        sys.stderr.write(text + "\n")


_SEPARATORS = {".csv": ",", ".tsv": "\t", ".csv.gz": ",", ".tsv.gz": "\t"}
_FIGURES = (".png", ".svg", ".pdf")


def check_files(
    inputs: Iterable[Path | None], out: Path | None, plot: Path | None, force: bool, *, table: bool = True
) -> None:
    """Before any work: raise UsageError for an output that could not be written; `table` False for a model file."""
    if out and table and _table_suffix(out) not in (*_SEPARATORS, ".parquet"):
        hint = "use .csv, .tsv, .csv.gz, .tsv.gz or .parquet"
        raise UsageError(f"cannot write a table as {_table_suffix(out)!r}", hint=hint, place=Place(str(out)))
    if out and not table and out.suffix.lower() not in (".yaml", ".yml"):
        hint = "name it .yaml, so that the other commands know it for a model"
        raise UsageError(f"cannot write a model as {out.suffix!r}", hint=hint, place=Place(str(out)))
    if plot and plot.suffix.lower() not in _FIGURES:
        hint = "use .png, .svg or .pdf"
        raise UsageError(f"cannot draw a figure as {plot.suffix!r}", hint=hint, place=Place(str(plot)))
    check_outputs(filter(None, (out, plot)), list(filter(None, inputs)), force)


def _table_suffix(path: Path) -> str:
    suffixes = [suffix.lower() for suffix in path.suffixes[-2:]]
    return "".join(suffixes) if suffixes[-1:] == [".gz"] else "".join(suffixes[-1:])


def write_table(frame: "pd.DataFrame", path: Path, force: bool) -> None:
    """Write a table as CSV, TSV (also .gz) or Parquet, by suffix; whole or not at all."""
    check_files((), path, None, force)
    suffix = _table_suffix(path)
    if suffix == ".parquet":
        write_with(path, lambda beside: frame.to_parquet(beside, index=False), force=force)
        return
    text = frame.to_csv(sep=_SEPARATORS[suffix], index=False).encode()
    packed = gzip.compress(text, mtime=0) if suffix.endswith(".gz") else text
    write_with(path, lambda beside: beside.write_bytes(packed), force=force)


def save_figure(figure: Any, path: Path, force: bool) -> None:
    """Write a matplotlib figure as png, svg or pdf, by suffix; undated, so that the bytes repeat."""
    check_files((), None, path, force)
    write_with(path, lambda beside: figure.savefig(beside, format=path.suffix[1:].lower()), force=force)


def with_processing(model: "Model", fit: str | None, degree: int | None, bandwidth: float | None) -> "Model":
    """The model with the filter options of the command line in place of those of the file."""
    given = {
        key: value for key, value in (("fit", fit), ("degree", degree), ("bandwidth", bandwidth)) if value is not None
    }
    if not given:
        return model
    if degree is not None and bandwidth is not None:
        raise UsageError("both --degree and --bandwidth are given", hint="give one: degree = pi * bandwidth * duration")
    cleared = {"degree": None, "bandwidth": None} if len(given.keys() - {"fit"}) else {}
    processing = model.processing.model_copy(update=cleared | given)
    return model.model_copy(update={"processing": processing})


def check_choice(value: str | None, choices: Sequence[str], option: str) -> None:
    """Raise UsageError unless the value is None or one of the choices."""
    if value is not None and value not in choices:
        raise UsageError(f"{option} {value!r} is unknown", hint=f"choose one of: {', '.join(choices)}")
