"""`chebid add`."""

from pathlib import Path
from typing import Annotated

import typer

from chebid.cli.common import Force, Json, Out, Plot, check_files, emit_json, held_out, quoted, save_figure, say, warn
from chebid.cli.diagnose import HoldoutLogs
from chebid.errors import UsageError


def add(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file (.yaml).", show_default=False)],
    what: Annotated[
        list[str],
        typer.Argument(
            metavar="EFFECT[:JOINT]... LOG...",
            help="Effects of the library or of your own, then logs.",
            show_default=False,
        ),
    ],
    holdout: HoldoutLogs = None,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Add effects to a model and fit it again.

    Their hyper-parameters are found on the logs. Error before and after, on the hold-out too.
    """
    from chebid.critiques import add_effects
    from chebid.model import read_model, settings_of, write_model
    from chebid.results import fitted_model

    effects = [name for name in what if not _is_log(name)]
    logs = [Path(name) for name in what if _is_log(name)]
    if not effects or not logs:
        missing = "log" if effects else "effect"
        raise UsageError(f"no {missing} is given", hint="chebid add MODEL EFFECT[:JOINT]... LOG... -o NEW.yaml")
    check_files((model, *logs, *(holdout or [])), out, plot, force, table=False)
    read = read_model(model)
    with settings_of(read):
        done = add_effects(read, effects, logs, holdout or [])
    warn(done.notices)
    if out:
        write_model(fitted_model(done.model, done.after, out), out, force=force)
    if plot:
        from chebid.report.torques import torque_figure

        save_figure(torque_figure(done.problem, {"with " + ", ".join(effects): done.after.theta}), plot, force)
    if json:
        emit_json(done.document(out))
        return
    from chebid.report.diagnosis import show_addition

    show_addition(done)
    if out:
        say(f"wrote {out}; next: chebid diagnose {quoted(out)} {' '.join(map(quoted, logs))}{held_out(holdout)}")


def _is_log(name: str) -> bool:
    from chebid.formats import named_like_a_log

    return named_like_a_log(Path(name)) or Path(name).exists()
