"""What a page tells: every model on every log, and a diagnosis of each model."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from chebid.critique import Diagnosis, candidate_kinds, diagnose
from chebid.critiques import make_case
from chebid.errors import Notice, Place, UsageError
from chebid.model import Model, settings_of
from chebid.results import Comparison, Comparisons, compare_models


@dataclass(frozen=True)
class Sheet:
    """One model: what it makes of every log, and what is wrong with it.

    `fitted`: names of the logs that it was fitted on; its structure is judged on these, the others are held out.
    """

    model: Model
    entries: tuple[Comparison, ...]
    diagnosis: Diagnosis
    fitted: frozenset[str]


@dataclass(frozen=True)
class Report:
    """Everything on a page."""

    comparisons: Comparisons
    sheets: tuple[Sheet, ...]
    notices: tuple[Notice, ...]


def collect(models: Sequence[Model], paths: Sequence[Path], seed: int = 0) -> Report:
    """Compare and diagnose fitted models on logs.

    Of the logs of a model, those that it was fitted on say what its structure lacks, and the others are its hold-out;
    where it was fitted on none of them, all say what has changed since. Raises InputError for a model without a fit,
    UsageError for a model or a log that is given twice.
    """
    _refuse_twins([model.path for model in models])
    comparisons = compare_models(list(models), list(paths))
    kinds, notices = candidate_kinds()
    sheets = []
    for model in models:
        entries = tuple(entry for entry in comparisons.entries if entry.problem.model is model)
        _refuse_copies(entries)
        known = model.fit.seen if model.fit else frozenset()
        own = [Path(entry.log) for entry in entries if entry.problem.logs[0].sha256 in known]
        others = [Path(entry.log) for entry in entries if Path(entry.log) not in own]
        with settings_of(model):
            case = make_case(model, own, others) if own else make_case(model, others, [])
            found = diagnose(case, kinds, seed)
        sheets.append(Sheet(model, entries, found, frozenset(map(str, own))))
    every = [*notices, *comparisons.notices, *(n for sheet in sheets for n in sheet.diagnosis.notices)]
    return Report(comparisons, tuple(sheets), tuple(dict.fromkeys(every)))


def _refuse_twins(paths: list[Path]) -> None:
    for i, path in enumerate(paths):
        if path in paths[:i]:
            raise UsageError("is given twice", hint="give each model once", place=Place(str(path)))


def _refuse_copies(entries: Sequence[Comparison]) -> None:
    seen: dict[str, str] = {}
    for entry in entries:
        first = seen.setdefault(entry.problem.logs[0].sha256, entry.log)
        if first != entry.log or sum(other.log == entry.log for other in entries) > 1:
            hint = "give it once: twice the same data are no more data"
            raise UsageError(f"is the same log as {first}", hint=hint, place=Place(entry.log))
