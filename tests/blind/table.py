"""The table that the loop has to reach, measured: quantity, required, measured, count; and who was taken for whom."""

from collections import Counter
from collections.abc import Callable, Iterable

import numpy as np

Row = dict[str, str]


def number(row: Row, key: str) -> float:
    return float(row[key]) if row.get(key) not in ("", None) else float("nan")


def share(rows: list[Row], good: Callable[[Row], bool]) -> tuple[str, int]:
    return (f"{100 * sum(map(good, rows)) / len(rows):.1f} %" if rows else "-", len(rows))


def spread(rows: list[Row], key: str) -> tuple[str, int]:
    values = np.array([number(row, key) for row in rows])
    values = values[np.isfinite(values)]
    if not len(values):
        return "-", 0
    return f"{np.median(values):.2f} / {np.percentile(values, 90):.2f}", len(values)


def table(rows: list[Row]) -> str:
    """Ratios of torque to noise are the ones reached, with a tolerance of 10 % for the tuning."""
    made = [row for row in rows if row["category"] != "not made"]
    one = [row for row in made if row["category"] == "one"]
    two, unknown = ([row for row in made if row["category"] == c] for c in ("two", "unknown"))
    clean, fault = ([row for row in made if row["category"] == c] for c in ("clean", "fault"))
    strong, middle = _above(one, 0.9), _above(one, 0.45, 0.9)
    sure = [row for row in made if row["sure_right"] != ""]
    hidden = _above([row for row in made if row["category"] in ("one", "two")], 0.9)
    real = [row for row in one if float(row["dnr"]) >= 0.45]
    flag = lambda key: lambda row: row[key] == "1"  # noqa: E731
    alarm = lambda row: row["status"] in ("missing", "unknown")  # noqa: E731
    timed = [row for row in made if row["joints"] == "2" and float(row["rate"]) == 100 and float(row["duration"]) <= 22]
    lines = [
        ("right effect and joint first, DNR >= 1", "95 %", share(strong, flag("first_right"))),
        ("right effect and joint first, DNR 0.5 to 1", "90 %", share(middle, flag("first_right"))),
        ("  (DNR below 0.5: no figure asked)", "", share(_above(one, 0.0, 0.45), flag("first_right"))),
        ("truth named or among 3 alternatives, DNR >= 0.5", "98 %", share(real, flag("among"))),
        ("sure verdicts that are right, any log", "98 %", share(sure, flag("sure_right"))),
        ("nothing missing: an effect named or unknown said", "<= 3 %", share(clean, alarm)),
        *((f"  {label}", "", share([row for row in clean if test(row)], alarm)) for label, test in _KINDS),
        ("nothing missing: refine adds an effect", "<= 3 %", share(clean, lambda row: row["added"] != "")),
        ("preprocessing faults: an effect called sure", "0 %", share(fault, lambda row: row["sure_right"] != "")),
        ("two hidden: first right", "97 %", share(two, flag("first_right"))),
        ("two hidden: both found", "85 %", share(two, flag("found"))),
        ("two hidden: exactly both", "75 %", share(two, flag("exact"))),
        ("one hidden, DNR >= 1: exactly it after refine", "", share(strong, flag("exact"))),
        ("residual / floor after the loop, DNR >= 1", "1.05 / 1.25", spread(hidden, "ratio_after")),
        ("  before", "", spread(hidden, "ratio_before")),
        ("  on another motion", "1.10 / 1.5", spread(hidden, "holdout_after")),
        ("  nothing missing, untouched", "", spread(clean, "ratio_before")),
        ("unknown effect: right variable or `unknown`", "85 %", share(_above(unknown, 0.45), flag("variable_right"))),
        ("  right variable", "", share(_above(unknown, 0.45), flag("variable_first"))),
        ("same physics, other formula: right name, DNR >= 1", "85 %",
         share([row for row in strong if row["law"] != "library"], flag("first_right"))),
        ("the library's own formula: right name, DNR >= 1", "",
         share([row for row in strong if row["law"] == "library"], flag("first_right"))),
        ("diagnose, processor s (2 joints, 100 Hz, <= 22 s)", "5 s", spread(timed, "seconds_diagnose")),
        ("refine, processor s (likewise)", "20 s", spread(timed, "seconds_refine")),
        ("DNR >= 1 and `nothing missing` said", "", share(hidden, lambda row: row["status"] == "nothing_missing")),
        ("tracebacks", "0", (str(sum("TRACEBACK" in row["trouble"] for row in made)), len(made))),
        ("logs without an answer", "0", (str(sum(row["status"] == "no answer" for row in made)), len(made))),
        ("logs that could not be simulated", "", (str(len(rows) - len(made)), len(rows))),
    ]  # fmt: skip
    wide = max(len(line[0]) for line in lines)
    head = f"{'quantity':{wide}}  {'required':>12}  {'measured':>14}  {'count':>5}"
    return "\n".join([head, *(f"{q:{wide}}  {r:>12}  {m:>14}  {n:5d}" for q, r, (m, n) in lines)])


_KINDS: tuple[tuple[str, Callable[[Row], bool]], ...] = (
    ("white noise, torque averaged", lambda row: row["colour"] == "0.0" and row["torque"] == "mean"),
    ("coloured noise, torque averaged", lambda row: row["colour"] != "0.0" and row["torque"] == "mean"),
    ("torque as commanded (half a control period early)", lambda row: row["torque"] == "command"),
)


def _above(rows: list[Row], low: float, high: float = np.inf) -> list[Row]:
    """Rows by the ratio reached; of effects that ring, by what is left of it at the frequencies of motions."""

    def ratio(row: Row) -> float:
        return float(row["slow"] if row["truth"].startswith("backlash") else row["dnr"])

    return [row for row in rows if low <= ratio(row) < high]


def confusion(rows: list[Row]) -> str:
    """Per hidden effect (DNR >= 0.5): count, right first, what it was taken for."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        if row["category"] in ("one", "unknown") and float(row["dnr"]) >= 0.45:
            groups.setdefault(row["truth"].split(":")[0], []).append(row)
        elif row["category"] in ("clean", "fault"):
            groups.setdefault(f"({row['fault'] or 'nothing'})", []).append(row)
    lines = [f"{'hidden':22} {'n':>3} {'right':>5} {'sure':>4}  said instead"]
    for name in sorted(groups):
        members = groups[name]
        right = sum(row["first_right"] == "1" for row in members)
        sure = sum(row["sure_right"] != "" for row in members)
        said = Counter(_answer(row) for row in members if row["first_right"] != "1")
        lines.append(f"{name:22} {len(members):3d} {right:5d} {sure:4d}  {_listed(said.most_common())}")
    return "\n".join(lines)


def _answer(row: Row) -> str:
    first = row["named"].split(";")[0]
    if row["status"] != "missing" or not first:
        return row["status"]
    name, _, joint = first.partition(":")
    same = row["truth"].split(":")[0] == name
    return f"{name} on {joint}" if same else name


def _listed(counts: Iterable[tuple[str, int]]) -> str:
    return ", ".join(f"{name} {n}" if n > 1 else name for name, n in counts)
