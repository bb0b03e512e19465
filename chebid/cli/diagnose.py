"""`chebid diagnose`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from chebid.cli.common import (
    Force,
    Json,
    LogPaths,
    Plot,
    Seed,
    check_files,
    emit_json,
    held_out,
    quoted,
    save_figure,
    say,
    warn,
)
from chebid.errors import Notice, Place

if TYPE_CHECKING:
    from chebid.critique import Diagnosis

HoldoutLogs = Annotated[
    list[Path] | None,
    typer.Option("--holdout", metavar="LOG", help="A log that the model is not fitted on; repeat for several."),
]


def diagnose(
    model: Annotated[Path, typer.Argument(metavar="MODEL", help="Fitted model (.yaml).", show_default=False)],
    log: LogPaths,
    holdout: HoldoutLogs = None,
    seed: Seed = 0,
    plot: Plot = None,
    json: Json = False,
    force: Force = False,
) -> None:
    """Tell where a model fails, on what, and which effect is missing.

    On the logs of its fit: what its structure lacks. On other logs: what has changed since.
    """
    from chebid.critique import candidate_kinds, diagnose, diagnosis_document
    from chebid.critiques import make_case
    from chebid.model import read_model, settings_of

    check_files((model, *log, *(holdout or [])), None, plot, force)
    read = read_model(model)
    kinds, notices = candidate_kinds()
    with settings_of(read):
        found = diagnose(make_case(read, log, holdout or []), kinds, seed)
    warn(notices)
    if read.fit is None:
        told = "has no fit: it is fitted on these logs here; `chebid identify` writes a fitted model"
        warn([Notice("unfitted", told, Place(file=str(model)))])
    if plot:
        from chebid.report.critique import diagnosis_figure

        save_figure(diagnosis_figure(found), plot, force)
    if json:
        warn(found.notices)
        emit_json(diagnosis_document(found))
        return
    from chebid.report.diagnosis import show_diagnosis

    show_diagnosis(found)
    _say_next(found, model, log, holdout or [])


def _say_next(found: "Diagnosis", model: Path, logs: list[Path], holdout: list[Path]) -> None:
    """The command to type."""
    from chebid.critique import failing, label

    joints = found.evidence.dynamics.joints
    verdict, given = found.verdict, " ".join(quoted(path) for path in logs)
    if verdict.status == "missing" and verdict.best is not None:
        name = label(verdict.best.effect, joints)
        if verdict.changed:
            typer.echo(
                f"next        chebid identify {given} --model {quoted(model)} -o {quoted(_beside(model, 'now'))}"
            )
            return
        rivals = " ".join(label(one.effect, joints) for one in verdict.alternatives)
        if rivals:
            first = "" if found.problem.model.limits else f"write limits: into {model}, then "
            typer.echo(f"separate    {first}chebid excite {quoted(model)} --separate {name} {rivals} -o separate.csv")
        new = quoted(_beside(model, verdict.best.effect.name))
        typer.echo(f"next        chebid add {quoted(model)} {name} {given}{held_out(holdout)} -o {new}")
    elif verdict.status == "nothing_missing" and found.holdout and failing(found.residual, found.holdout):
        say(f"next: chebid diagnose {quoted(model)} {' '.join(map(quoted, holdout))}")
    elif verdict.status == "nothing_missing" and found.problem.model.fit is not None:
        say(f"next: chebid compare {quoted(model)} {quoted(holdout[0]) if holdout else 'LOG, of another motion'}")


def _beside(model: Path, word: str) -> Path:
    return model.with_name(f"{model.stem}_{word}.yaml")
