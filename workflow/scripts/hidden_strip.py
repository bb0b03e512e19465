"""The worked example: hidden_strip.py SETTINGS TABLE.csv SVG PNG; SETTINGS holds hidden.example: model, log, holdout.

The table has the error over the noise floor after every step, the figure four pictures of the search.
"""

import argparse
import json
from pathlib import Path

import pandas as pd

from chebid.critique import Refinement, candidate_kinds, diagnose, label, refine
from chebid.critiques import make_case, refinement_problems
from chebid.files import write_with
from chebid.model import read_model
from chebid.report.critique import strip_figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("table", type=Path)
    parser.add_argument("figures", type=Path, nargs=2)
    given = parser.parse_args()
    own = given.settings["hidden"]["example"]
    model, logs, holdout = read_model(own["model"]), [Path(own["log"])], [Path(own["holdout"])]
    kinds, _ = candidate_kinds()
    problem, other, method = refinement_problems(model, logs, holdout)
    found = refine(problem, kinds, holdout=other, method=method)
    write_with(given.table, lambda beside: ladder(found).to_csv(beside, index=False), force=True)
    figure = strip_figure(diagnose(make_case(model, logs, holdout), kinds), found)
    for path in given.figures:
        write_with(path, figure.savefig, force=True)
    print(ladder(found).to_string(index=False))


def ladder(found: Refinement) -> pd.DataFrame:
    """Error over noise floor by step and joint, on the log and on the hold-out."""
    rows = []
    for number, step in enumerate(found.steps):
        held = step.diagnosis.holdout_ratio or {}
        for joint, residual in step.estimate.residual.items():
            added = label(step.effect, found.model.joints) if step.effect else "as given"
            both = {"ratio": residual.ratio, "holdout_ratio": held.get(joint)}
            rows.append({"step": number, "joint": joint, "added": added} | both)
    return pd.DataFrame(rows)


if __name__ == "__main__":
    main()
