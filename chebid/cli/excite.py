"""`chebid excite`."""

import os
import sys
from collections.abc import Callable
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
from chebid.errors import UsageError

if TYPE_CHECKING:
    from chebid.excite import Excitation, Separated, Size
    from chebid.model import Model

_BAR = 30


def excite(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file with limits:.", show_default=False)],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="TRAJ", help="Write the trajectory there.", show_default=False)
    ],
    more: Annotated[list[str] | None, typer.Argument(metavar="RIVAL", hidden=True)] = None,
    separate: Annotated[
        list[str] | None,
        typer.Option(
            "--separate",
            metavar="EFFECT[:JOINT] EFFECT[:JOINT]...",
            help="Find a motion that tells these effects apart, of which the model lacks one.",
        ),
    ] = None,
    log: Annotated[
        list[Path] | None,
        typer.Option("--log", metavar="LOG", help="With --separate: a log of the fit; else looked for beside MODEL."),
    ] = None,
    moves: Annotated[
        int | None, typer.Option("--moves", metavar="M", help="Moves between points, or harmonics (9; to separate 14).")
    ] = None,
    duration: Annotated[
        float | None, typer.Option("--duration", metavar="S", help="Of the whole trajectory (8; to separate 20).")
    ] = None,
    kind: Annotated[str, typer.Option("--kind", metavar="KIND", help="points or fourier.")] = "points",
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Samples of the trajectory.")] = 100.0,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of the random starts.", min=0)] = 0,
    starts: Annotated[
        int | None,
        typer.Option("--starts", metavar="K", help="Optimisations, the best of which counts (8; to separate 4)."),
    ] = None,
    information: Annotated[
        float | None,
        typer.Option("--information", metavar="W", help="Weight of fast motion against eq. 23 (1.2; 0: none)."),
    ] = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Find a trajectory that excites all parameters, or one that separates rival effects.

    Criterion of eq. 23, cond(W) + 1/sigma_min(W), under the limits of the model file; with --separate the smallest
    difference in score between rivals. Columns t, q1.., dq1.., ddq1..
    """
    from chebid.excite import KINDS, trajectory_table
    from chebid.model import read_model, settings_of

    model, rivals = _sorted_out(model, more or [], separate or [])
    _check_options(rivals, log or [], information)
    check_choice(kind, KINDS, "--kind")
    check_files((model, *(log or [])), out, plot, force)
    read = read_model(model)
    options: dict[str, Any] = {"duration": duration, "moves": moves, "starts": starts, "information": information}
    options = {key: value for key, value in options.items() if value is not None}
    options |= {"kind": kind, "rate": rate, "seed": seed}
    with settings_of(read):
        found, apart = _found(read, rivals, log or [], options)
    if apart:
        warn(apart.notices)
    write_table(trajectory_table(found), out, force)
    if plot:
        from chebid.report.motion import excitation_figure
        from chebid.robots import make_robot

        save_figure(excitation_figure(found, read.joints, make_robot(read).rotary), plot, force)
    if json:
        document = _document(found, read.joints, out)
        emit_json(document | (_apart_document(apart, read.joints) if apart else {}))
        return
    if apart:
        _show_apart(apart, read.joints)
        _show_used(found, read.joints)
        say(f"next: record a log along {out}, then: chebid identify OLD_LOG NEW_LOG --model {model} -o NEW.yaml")
        say("      and: chebid diagnose NEW.yaml OLD_LOG NEW_LOG")
    else:
        _show(found, read.joints)


def _sorted_out(model: Path, more: list[str], separate: list[str]) -> tuple[Path, list[str]]:
    """Model file and rivals: the rivals after the first stand among the arguments, where a shell leaves them."""
    if more and not separate:
        raise UsageError(f"unexpected argument {more[0]!r}", hint="rivals come after --separate")
    given = [str(model), *more]
    files = [name for name in given if Path(name).suffix.lower() in (".yaml", ".yml")]
    if more and len(files) != 1:
        raise UsageError(
            "one model file and rival effects are needed", hint="chebid excite MODEL.yaml --separate A:JOINT B:JOINT"
        )
    chosen = files[0] if more else str(model)
    given.remove(chosen)
    return Path(chosen), [*separate, *given]


def _check_options(rivals: list[str], logs: list[Path], information: float | None) -> None:
    """Raise UsageError for options that go with the other kind of search."""
    if logs and not rivals:
        raise UsageError("--log is given without --separate", hint="say which rivals to separate")
    if rivals and information is not None:
        raise UsageError("--information goes with eq. 23, not with --separate", hint="leave it out")


def _found(
    model: "Model", rivals: list[str], logs: list[Path], options: dict[str, Any]
) -> "tuple[Excitation, Separated | None]":
    from chebid.excite import excite, separate

    if not rivals:
        with _Bar("criterion {:.3f}") as progress:
            return excite(model, progress=progress, **options), None
    with _Bar("score difference {:.1f}") as progress:
        apart = separate(model, rivals, logs=logs, progress=progress, **options)
    return apart.excitation, apart


class _Bar:
    """Progress on stderr, when that is a terminal; `text` with a place for the best value so far."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __enter__(self) -> Callable[[int, int, float], None]:
        self.on = sys.stderr.isatty() and not os.environ.get("CHEBID_QUIET")
        return self._draw

    def _draw(self, done: int, total: int, best: float) -> None:
        if self.on:
            full = _BAR * done // total
            bar = "#" * full + "-" * (_BAR - full)
            sys.stderr.write(f"\r[{bar}] {done}/{total}, {self.text.format(best)}")
            sys.stderr.flush()

    def __exit__(self, *error: object) -> None:
        if self.on:
            sys.stderr.write("\r\x1b[K")


def _show(found: "Excitation", joints: tuple[str, ...]) -> None:
    score = found.score
    typer.echo(
        f"criterion {score.value:.4g}, condition number {score.condition:.4g}, "
        f"smallest singular value {score.smallest:.4g}"
    )
    typer.echo(f"before: {found.before.value:.4g} (best random motion), {found.median_before:.4g} (their median)")
    _show_used(found, joints)


def _show_used(found: "Excitation", joints: tuple[str, ...]) -> None:
    width = max(len("limit used"), *map(len, joints))
    typer.echo(f"{'limit used':<{width}}  position  velocity  acceleration")
    for name, (position, velocity, acceleration) in zip(joints, found.used.T, strict=True):
        typer.echo(f"{name:<{width}}  {position:>8.0%}  {velocity:>8.0%}  {acceleration:>12.0%}")


def _document(found: "Excitation", joints: tuple[str, ...], out: Path) -> dict[str, Any]:
    used = {
        quantity: dict(zip(joints, row, strict=True))
        for quantity, row in zip(("position", "velocity", "acceleration"), found.used, strict=True)
    }
    return {
        "trajectory": str(out),
        "criterion": found.score.value,
        "criterion_before": found.before.value,
        "criterion_random": found.median_before,
        "condition_number": found.score.condition,
        "smallest_singular_value": found.score.smallest,
        "limits_used": used,
        "durations": found.durations,
        "starts": found.starts,
    }


def _show_apart(apart: "Separated", joints: tuple[str, ...]) -> None:
    """Score differences, before and after, and what they rest on."""
    from chebid.excite.separate import ENOUGH

    rows = [(" | ".join(pair.rivals), f"{pair.before:.3g}", f"{pair.after:.3g}") for pair in apart.pairs]
    was = "on the logs of the fit" if apart.before == "log" else "best random motion"
    table = [("rivals", was, "this motion"), *rows]
    widths = [max(len(row[i]) for row in table) for i in range(3)]
    typer.echo("difference of scores between the truth and its best imitation, whichever of the two it is:")
    for name, before, after in table:
        typer.echo(f"{name:<{widths[0]}}  {before:>{widths[1]}}  {after:>{widths[2]}}")
    typer.echo(f"from {ENOUGH:g} on a diagnosis tells them apart; scores of several logs add up")
    for size in apart.sizes:
        typer.echo(f"assumed     {_described(size, joints)}")
    typer.echo(f"noise       {', '.join(f'{x:.3g}' for x in apart.noise.deviation)} ({apart.noise.source})")


def _described(size: "Size", joints: tuple[str, ...]) -> str:
    """A rival as it was taken to be, in words."""
    named = zip(size.effect.symbols, size.values, strict=False)
    settings = {name: value for name, value in size.effect.settings(joints).items()}
    numbers = [f"{name} {value:.3g}" for name, value in named] + [
        f"{name} {value:.3g}" if isinstance(value, int | float) else f"{name} {value}"
        for name, value in settings.items()
    ]
    why = "fitted on the logs" if size.from_log else "as strong as the noise"
    return f"{size.rival} {', '.join(numbers)}: {why}"


def _apart_document(apart: "Separated", joints: tuple[str, ...]) -> dict[str, Any]:
    from chebid.excite import ENOUGH

    return {
        "separability": apart.least,
        "enough": ENOUGH,
        "before_motion": apart.before,
        "pairs": [
            {
                "rivals": list(pair.rivals),
                "before": pair.before,
                "after": pair.after,
                "hardest": {
                    "truth": {"effect": pair.truth.name, "hyperparameters": pair.truth.settings(joints)},
                    "imitator": {"effect": pair.imitator.name, "hyperparameters": pair.imitator.settings(joints)},
                },
            }
            for pair in apart.pairs
        ],
        "assumed": [
            {
                "rival": size.rival,
                "values": dict(zip(size.effect.symbols, size.values, strict=False)),
                "hyperparameters": size.effect.settings(joints),
                "from": "log" if size.from_log else "noise",
            }
            for size in apart.sizes
        ],
        "noise": {
            "deviation": dict(zip(joints, apart.noise.deviation, strict=True)),
            "source": apart.noise.source,
        },
        "warnings": [str(notice) for notice in apart.notices],
    }
