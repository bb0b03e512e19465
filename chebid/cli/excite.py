"""`chebid excite`."""

import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from chebid.cli.common import Force, Json, Plot, check_choice, check_files, emit_json, save_figure, write_table

if TYPE_CHECKING:
    from chebid.excite import Excitation

_BAR = 30


def excite(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file with limits:.", show_default=False)],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="TRAJ", help="Write the trajectory there.", show_default=False)
    ],
    moves: Annotated[int, typer.Option("--moves", metavar="M", help="Moves between points, or harmonics.")] = 9,
    duration: Annotated[float, typer.Option("--duration", metavar="S", help="Of the whole trajectory.")] = 8.0,
    kind: Annotated[str, typer.Option("--kind", metavar="KIND", help="points or fourier.")] = "points",
    rate: Annotated[float, typer.Option("--rate", metavar="HZ", help="Samples of the trajectory.")] = 100.0,
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Of the random starts.", min=0)] = 0,
    starts: Annotated[int, typer.Option("--starts", metavar="K", help="Optimisations, the best of which counts.")] = 8,
    information: Annotated[
        float, typer.Option("--information", metavar="W", help="Of small errors against eq. 23: 0 none, 100 all.")
    ] = 1.2,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Find a trajectory that excites all parameters.

    Criterion of eq. 23, cond(W) + 1/sigma_min(W), under the limits of the model file. Columns t, q1.., dq1.., ddq1..

    Eq. 23 alone favours slow motions, whose errors are several times larger. --information weighs in how much a motion
    tells (D-optimality): the default keeps the criterion small, 100 gives the least errors and a larger criterion.
    """
    from chebid.excite import KINDS, excite, trajectory_table
    from chebid.model import read_model

    check_choice(kind, KINDS, "--kind")
    check_files((model,), out, plot, force)
    read = read_model(model)
    options: dict[str, Any] = {"duration": duration, "moves": moves, "kind": kind, "rate": rate, "seed": seed}
    options |= {"starts": starts, "information": information}
    with _Bar() as progress:
        found = excite(read, progress=progress, **options)
    write_table(trajectory_table(found), out, force)
    if plot:
        from chebid.report.motion import excitation_figure
        from chebid.robots import make_robot

        save_figure(excitation_figure(found, read.joints, make_robot(read).rotary), plot, force)
    if json:
        emit_json(_document(found, read.joints, out))
    else:
        _show(found, read.joints)


class _Bar:
    """Progress on stderr, when that is a terminal."""

    def __enter__(self) -> Callable[[int, int, float], None]:
        self.on = sys.stderr.isatty() and not os.environ.get("CHEBID_QUIET")
        return self._draw

    def _draw(self, done: int, total: int, best: float) -> None:
        if self.on:
            full = _BAR * done // total
            bar = "#" * full + "-" * (_BAR - full)
            sys.stderr.write(f"\r[{bar}] {done}/{total}, criterion {best:.3f}")
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
