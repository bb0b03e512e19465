"""What the hidden-effect study shows: hidden_pages.py FOLDER LOG.json...

Writes into FOLDER hidden_accuracy and hidden_confusion (csv, svg, png) and hidden_summary (csv, md).
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from hiding import NOTHING
from matplotlib.figure import Figure

from chebid.files import write_with
from chebid.report.hidden import accuracy_figure, confusion_figure

UNKNOWN, NO_ANSWER = "unknown", "no answer"
OTHER_JOINT = "other joint"
_EITHER_JOINT = ("torque_gain",)  # shows only between both
_ALTERNATIVES = 3
#: column of the summary -> what it means
ABOUT = {
    "logs": "logs, those without an answer included",
    "no answer": "logs that could not be simulated, or that chebid refused",
    "right first": "the hidden effect named first, on its joint (if nothing is hidden: nothing named), %",
    "among": "the hidden effect named, or among the printed alternatives (at most 3), %",
    "sure": "verdicts called sure, %",
    "sure and right": "of the verdicts called sure and naming an effect, those that are right, %",
    "false alarms": "logs with nothing hidden that got an effect, or `unknown`, %",
    "before": "error over noise floor of the worst joint, median, before refining",
    "after": "the same after refining",
    "after, 90 %": "the same, 90th percentile",
    "hold-out before": "the same as `before` on a log along another motion",
    "hold-out after": "the same as `after` on that log",
    "diagnose s": "seconds of `chebid diagnose`, start included, median",
    "refine s": "seconds of `chebid refine`, start included, median",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("logs", type=Path, nargs="+")
    given = parser.parse_args()
    table = pd.DataFrame([judged(json.loads(log.read_text(encoding="utf-8"))) for log in given.logs])
    shares, counts, numbers = accuracy(table), confusion(table), summary(table)
    for name, frame in (("accuracy", shares), ("confusion", counts), ("summary", numbers)):
        path = given.folder / f"hidden_{name}.csv"
        write_with(path, lambda beside, frame=frame: frame.to_csv(beside, index=False), force=True)
    save(accuracy_figure(shares), given.folder / "hidden_accuracy")
    save(confusion_figure(counts), given.folder / "hidden_confusion")
    page = markdown(numbers)
    path = given.folder / "hidden_summary.md"
    write_with(path, lambda beside: Path(beside).write_text(page, encoding="utf-8"), force=True)
    print(page)


def save(figure: Figure, path: Path) -> None:
    for suffix in (".svg", ".png"):
        write_with(path.with_suffix(suffix), figure.savefig, force=True)


def judged(log: dict[str, Any]) -> dict[str, Any]:
    """One log as a row: what was hidden, what was named, whether that is right, the errors."""
    truth, verdict = log["truth"], log["verdict"]
    row = {"case": log["case"], "effect": truth["effect"], "strength": truth["strength"], "motion": log["motion"]}
    row |= {"noise": log["noise"], "answered": bool(verdict), "sure": bool(verdict.get("sure"))}
    row |= {"named": named(truth, verdict), "status": verdict.get("status", NO_ANSWER)}
    said = [*verdict["effects"][:1], *verdict["alternatives"][:_ALTERNATIVES]] if row["status"] == "missing" else []
    row |= {"right": row["named"] == truth["effect"], "among": any(right(truth, one) for one in said)}
    for name in ("ratio", "holdout_ratio"):
        steps = [worst(step) for step in log[name]]
        row |= {f"{name}_before": steps[0] if steps else None, f"{name}_after": steps[-1] if steps else None}
    return row | {f"{name}_s": log["seconds"].get(name) for name in ("diagnose", "refine")}


def named(truth: dict[str, Any], verdict: dict[str, Any]) -> str:
    """The effect that a verdict names first, or that it says nothing, or does not know."""
    if not verdict:
        return NO_ANSWER
    if verdict["status"] == "missing" and verdict["effects"]:
        first = verdict["effects"][0]
        return OTHER_JOINT if first["effect"] == truth["effect"] and not right(truth, first) else str(first["effect"])
    return NOTHING if verdict["status"] == "nothing_missing" else UNKNOWN


def right(truth: dict[str, Any], said: dict[str, Any]) -> bool:
    """Whether an effect that was named is the hidden one, on its joint."""
    if said["effect"] != truth["effect"]:
        return False
    return truth["effect"] in _EITHER_JOINT or said["joint"] == truth["joint"]


def worst(step: dict[str, float | None] | None) -> float | None:
    return max((ratio for ratio in (step or {}).values() if ratio is not None), default=None)


def accuracy(table: pd.DataFrame) -> pd.DataFrame:
    """Per hidden effect and strength: logs with an answer, and how many of them had it named first."""
    mine = table[(table.effect != NOTHING) & table.answered]
    found = mine.groupby(["effect", "strength"], sort=True).right.agg(["sum", "count"]).reset_index()
    return found.rename(columns={"sum": "right", "count": "logs"}).astype({"right": int})


def confusion(table: pd.DataFrame) -> pd.DataFrame:
    """Per hidden effect and what was named: how many logs."""
    kept = table[table.answered]
    return kept.groupby(["effect", "named"]).size().rename("logs").reset_index()


def summary(table: pd.DataFrame) -> pd.DataFrame:
    """The columns of `ABOUT`, by strength, for all hidden effects, and for nothing hidden."""
    hidden = table[table.effect != NOTHING]
    groups = [(f"strength {size:g}", hidden[hidden.strength == size]) for size in sorted(hidden.strength.unique())]
    groups += [("every strength", hidden), ("nothing hidden", table[table.effect == NOTHING])]
    return pd.DataFrame([{"hidden": name} | figures(group, name == "nothing hidden") for name, group in groups])


def figures(group: pd.DataFrame, nothing: bool) -> dict[str, float | None]:
    kept = group[group.answered]
    called = kept[kept.sure & (kept.status == "missing")]
    alarms = percent(~kept.right) if nothing else None
    return {
        "logs": len(group),
        "no answer": len(group) - len(kept),
        "right first": percent(kept.right),
        "among": None if nothing else percent(kept.among),
        "sure": percent(kept.sure),
        "sure and right": percent(called.right),
        "false alarms": alarms,
        "before": kept.ratio_before.median(),
        "after": kept.ratio_after.median(),
        "after, 90 %": kept.ratio_after.quantile(0.9),
        "hold-out before": kept.holdout_ratio_before.median(),
        "hold-out after": kept.holdout_ratio_after.median(),
        "diagnose s": kept.diagnose_s.median(),
        "refine s": kept.refine_s.median(),
    }


def percent(values: "pd.Series[bool]") -> float | None:
    return 100 * float(values.mean()) if len(values) else None


def markdown(numbers: pd.DataFrame) -> str:
    """The summary for reading, one column per group."""
    groups = list(numbers.hidden)
    lines = [f"| | {' | '.join(groups)} |", "|---" * (len(groups) + 1) + "|"]
    for name in ABOUT:
        cells = ["" if pd.isna(value) else f"{value:.3g}" for value in numbers[name]]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join([*lines, "", *explained(list(ABOUT))]) + "\n"


def explained(names: Sequence[str]) -> list[str]:
    strength = (
        "rms torque that rigid links, viscous and Coulomb friction cannot explain, over the torque noise; of a spring "
        "or a gap behind the motor to first order, which is less than it does"
    )
    return [f"- strength: {strength}", *(f"- {name}: {ABOUT[name]}" for name in names)]


if __name__ == "__main__":
    main()
