"""`chebid refine`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from chebid.cli.common import (
    Force,
    Json,
    LogPaths,
    Out,
    Plot,
    Seed,
    check_files,
    emit_json,
    quoted,
    save_figure,
    say,
    warn,
)
from chebid.cli.diagnose import HoldoutLogs

if TYPE_CHECKING:
    from chebid.critique import Step


def refine(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Model file (.yaml).", show_default=False)],
    log: LogPaths,
    holdout: HoldoutLogs = None,
    seed: Seed = 0,
    out: Out = None,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Diagnose and add until nothing is missing.

    Fits the model on the logs, adds the effect that is missing, drops what is no longer needed, and so on.
    """
    from chebid.critique import candidate_kinds, refine, refinement_document
    from chebid.critiques import refined_model, refinement_problems
    from chebid.model import read_model, settings_of, write_model

    check_files((model, *log, *(holdout or [])), out, plot, force, table=False)
    read = read_model(model)
    kinds, notices = candidate_kinds()
    with settings_of(read):
        problem, held_out, method = refinement_problems(read, log, holdout or [])
        done = refine(problem, kinds, holdout=held_out, method=method, seed=seed, progress=_tell)
    warn([*notices, *done.last.estimate.notices])
    if out:
        write_model(refined_model(done, out), out, force=force)
    if plot:
        from chebid.report.critique import ladder_figure

        save_figure(ladder_figure(done), plot, force)
    if json:
        emit_json(refinement_document(done))
        return
    from chebid.report.diagnosis import show_refinement

    show_refinement(done)
    if out:
        seen = quoted((holdout or log)[0])
        say(f"wrote {out}; next: chebid compare {quoted(out)} {seen} --plot errors.png")


def _tell(step: "Step") -> None:
    from chebid.report.diagnosis import show_step

    say(show_step(step))
