"""`chebid freqresp`."""

from typing import TYPE_CHECKING, Annotated

import typer

from chebid.cli.common import (
    Bandwidth,
    Basis,
    Fit,
    Force,
    Json,
    Out,
    Plot,
    check_choice,
    emit_json,
    save_figure,
    say,
    write_table,
)
from chebid.errors import UsageError

if TYPE_CHECKING:
    from chebid.response import Sweep

_ROWS = 12  # of the default grid, on a terminal


def freqresp(
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Sampling rate.", show_default=False)],
    duration: Annotated[float, typer.Option("--duration", metavar="S", help="Length of a record.", show_default=False)],
    degree: Annotated[
        int | None,
        typer.Option("--degree", "-n", metavar="N", help="Degree on the whole record, or on each --window."),
    ] = None,
    bandwidth: Bandwidth = None,
    order: Annotated[int, typer.Option("--order", metavar="K", help="Derivative: 0, 1 or 2.")] = 0,
    fit: Fit = None,
    basis: Basis = "chebyshev",
    window: Annotated[float | None, typer.Option("--window", metavar="S", help="Length of windows (--degree).")] = None,
    penalty: Annotated[
        float | None, typer.Option("--penalty", metavar="HZ", help="Half-gain frequency of the penalty (smooth).")
    ] = None,
    frequency: Annotated[
        list[float] | None, typer.Option("--frequency", metavar="F...", help="Frequencies in Hz instead of a grid.")
    ] = None,
    more: Annotated[list[float] | None, typer.Argument(metavar="[F]...", hidden=True)] = None,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Show what the projection does to each frequency.

    Gain (dB), phase (deg) and -3 dB cut-off of exactly the operator that the other commands use, relative to the ideal
    one (1, i w, -w^2); with --bandwidth the degree that gives it. Needs no log.
    """
    from chebid.basis import FAMILIES
    from chebid.files import refuse_existing
    from chebid.projection import FITS
    from chebid.response import Wish, sweep

    check_choice(fit, FITS, "--fit")
    check_choice(basis, tuple(FAMILIES), "--basis")
    asked = _frequencies(frequency, more)
    for path in filter(None, (out, plot)):
        refuse_existing(path, force)
    result = sweep(rate, duration, Wish(degree, bandwidth, fit or "lsq", basis, window, penalty), order, asked)
    if out:
        import pandas as pd

        write_table(pd.DataFrame(result.columns()), out, force)
    if plot:
        from chebid.report.frequency import sweep_figure

        save_figure(sweep_figure(result), plot, force)
    if fit == "smooth" and degree and not penalty:
        say("remark: --penalty is not given; the other commands choose it from the data, here it follows the degree")
    if json:
        emit_json(result.document())
    else:
        typer.echo(_text(result, whole=bool(asked)))


def _frequencies(first: list[float] | None, more: list[float] | None) -> list[float] | None:
    """`--frequency 1 2 3`: the option takes the first number, the others come as arguments."""
    if more and not first:
        raise UsageError(f"what is {more[0]:g}?", hint="freqresp reads no file; frequencies follow --frequency")
    return sorted({*(first or []), *(more or [])}) or None


def _text(result: "Sweep", whole: bool) -> str:
    """A table of all the rows asked for or of some of the grid, and the operator in a sentence."""
    columns = list(result.columns().values())
    count = len(columns[0])
    shown = range(count) if whole else range(-(-count // _ROWS) - 1, count, -(-count // _ROWS))
    heads = f"{'frequency Hz':>12}{'gain dB':>12}{'whole dB':>12}{'phase deg':>12}"
    rows = [
        f"{f:>12.5g}{gain:>12.4f}{all_over:>12.4f}{phase:>12.4f}"
        for f, gain, all_over, phase in zip(*(column[shown].round(4) + 0.0 for column in columns), strict=True)
    ]
    skipped = [] if len(shown) == count else [f"({len(shown)} of {count} frequencies; -o or --json gives all)"]
    return "\n".join([heads, *rows, *skipped, "", result.sentence()])
