"""Table 1: published, estimated and true: table_1.py SETTINGS RECORD.csv CSV MD TEX, with the section `scara`."""

import argparse
import json
from pathlib import Path

import pandas as pd
from shown import short
from study import estimates, identifiable, with_prior

from chebid.errors import ChebidError
from chebid.estimators import METHODS, Problem
from chebid.files import write_text, write_with
from chebid.log import read_log
from chebid.model import read_model
from chebid.results import fitted_values

NAMES = ("ZZR1", "Fv1", "Fs1", "ZZ2", "LMX2", "LMY2", "Fv2", "Fs2")
# value and relative deviation (%), as printed in the paper
PUBLISHED = {
    "poly": ((3.43, 0.04, 0.75, 0.061, 0.123, 0.008, 0.033, 0.098), (0.2, 3.6, 3.0, 3.6, 1.6, 1.6, 41, 2.2)),
    "wls": ((3.47, 0.3, 0.4, 0.064, 0.125, 0.003, 0.014, 0.13), (0.8, 25, 9, 0.45, 1.2, 49, 6, 1.7)),
    "ekf": ((3.31, 0.6, 0.58, 0.061, 0.14, 0.03, 0.012, 0.13), (0.2, 3.6, 1.1, 0.1, 0.4, 1.0, 1.1, 0.3)),
    "iv": ((3.45, 0.02, 0.82, 0.061, 0.125, 0.014, 0.01, 0.135), (0.5, 25, 5, 0.4, 5, 0.4, 30, 7)),
    "huber": ((3.45, 0.01, 0.83, 0.061, 0.125, 0.012, 0.0, 0.135), (0.5, 30, 4.8, 0.5, 0.4, 5.5, 100, 7)),
    "dr": ((3.35, 0.02, 0.48, 0.059, 0.129, 0.004, 0.038, 0.082), (0.2, 8.9, 6.6, 0.5, 0.5, 9.7, 4.6, 3.3)),
}
# what contradicts itself in print: a mark at the cell, and a note beneath
MARKS = {
    ("iv", "LMX2", "deviation"): "a",
    ("iv", "LMY2", "deviation"): "a",
    ("poly", "Fv1", "deviation"): "b",
    ("poly", "ZZ2", "deviation"): "b",
    ("wls", "Fv1", "value"): "c",
    ("ekf", "Fv1", "value"): "c",
}
NOTES = {
    "a": "LMX2 and LMY2 look swapped: 5 % of LMX2 is more, and 0.4 % of LMY2 less, than any other method gives.",
    "b": "The same 3.6 stands under Fv1 and under ZZ2, and again under Fv1 of ekf.",
    "c": "0.3 and 0.6 against 0.01 to 0.04 of the other methods, many deviations away.",
}
HEADS = {
    "published": "published",
    "published_deviation": "published % sd",
    "value": "estimated",
    "deviation_eq26": "% sd, eq. 26",
    "deviation": "% sd, honest",
}


def table(settings: dict, record: Path) -> pd.DataFrame:
    """One row per parameter and method."""
    truth = read_model(settings["model"])
    model = identifiable(with_prior(truth, settings["prior"], settings["seed"]), settings["motion"]["rate"])
    problem = Problem(model, (read_log(record, model.log, model.joints, need_torque=True),))
    true = dict(zip((p.name for p in problem.dynamics.parameters), fitted_values(truth), strict=True))
    rows = []
    for method, found, _ in estimates(problem, list(METHODS)):
        if isinstance(found, ChebidError):
            raise found
        for i, p in enumerate(found.parameters):
            value, deviation = (part[NAMES.index(p.name)] for part in PUBLISHED[method])
            ours = found.theta[i], found.relative(found.sd_white)[i], found.relative(found.sd)[i]
            rows.append((p.name, method, value, deviation, *ours, true[p.name], p.unit))
    columns = ["parameter", "method", *HEADS, "truth", "unit"]
    return pd.DataFrame(rows, columns=columns)


def cells(frame: pd.DataFrame) -> list[tuple[str, str, list[str]]]:
    """Lines of the printed table: method, what, and one cell per parameter."""
    out = []
    for method in METHODS:
        mine = frame[frame.method == method].set_index("parameter")
        for column, head in HEADS.items():
            kind = {"published": "value", "published_deviation": "deviation"}.get(column, "")
            shown = "{:.4g}".format if column == "value" else short if column.startswith("deviation") else "{:g}".format
            line = [shown(abs(mine[column][n]) if "deviation" in column else mine[column][n]) for n in NAMES]
            marks = [MARKS.get((method, name, kind), "") for name in NAMES]
            out.append(
                (method, head, [f"{cell}^{mark}" if mark else cell for cell, mark in zip(line, marks, strict=True)])
            )
    true = frame.drop_duplicates("parameter").set_index("parameter").truth
    return [*out, ("", "truth", [f"{true[name]:g}" for name in NAMES])]


def markdown(frame: pd.DataFrame) -> str:
    lines = ["| method | | " + " | ".join(NAMES) + " |", "|---" * (len(NAMES) + 2) + "|"]
    for method, head, line in cells(frame):
        shown = [f"{cell.replace('^', '<sup>')}</sup>" if "^" in cell else cell for cell in line]
        lines.append(f"| {method if head in ('published', 'truth') else ''} | {head} | " + " | ".join(shown) + " |")
    notes = [f"<sup>{mark}</sup> {text}" for mark, text in NOTES.items()]
    return "\n\n".join(["\n".join(lines), *ABOUT, *notes]) + "\n"


def latex(frame: pd.DataFrame) -> str:
    lines = [r"\begin{tabular}{ll" + "r" * len(NAMES) + "}", r"\hline", " & & " + " & ".join(NAMES) + r" \\"]
    for method, head, line in cells(frame):
        shown = [f"{cell.replace('^', '$^{')}}}$" if "^" in cell else cell for cell in line]
        rule = r"\hline" + "\n" if head in ("published", "truth") else ""
        first = rf"\texttt{{{method}}}" if head == "published" else ""
        lines.append(f"{rule}{first} & {head} & ".replace("%", r"\%") + " & ".join(shown) + r" \\")
    notes = [rf"% $^{{{mark}}}$ {text}" for mark, text in NOTES.items()]
    return "\n".join([*lines, r"\hline", r"\end{tabular}", *notes]) + "\n"


ABOUT = (
    "SI units. *Published*: table 1 of the paper, as printed, on measurements of a real robot that are not public. "
    "*Estimated*: by chebid on one simulated closed-loop record of a robot with the parameters of the last line; "
    "the two are not to be compared in the last digit.",
    "*% sd*: standard deviation relative to the estimate, by eq. 26 (white residuals) and honest (with the correlation "
    "and the spectrum that the residuals show). Where the print contradicts itself:",
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("record", type=Path)
    parser.add_argument("csv", type=Path)
    parser.add_argument("md", type=Path)
    parser.add_argument("tex", type=Path)
    given = parser.parse_args()
    frame = table(given.settings["scara"], given.record)
    numbers = frame.drop(columns="unit")
    write_with(given.csv, lambda beside: numbers.to_csv(beside, index=False, float_format="%.6g"), force=True)
    write_text(given.md, markdown(frame), force=True)
    write_text(given.tex, latex(frame), force=True)
    print(f"{given.csv}: {len(frame)} rows")


if __name__ == "__main__":
    main()
