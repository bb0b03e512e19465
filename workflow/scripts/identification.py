"""Identify the bundled log: identification.py SETTINGS TABLE.csv SVG PNG MODEL.yaml.

SETTINGS is JSON with the section `identification` of the configuration: model, log.
"""

import argparse
import json
from pathlib import Path

import pandas as pd

from chebid.estimators import Problem, estimate
from chebid.files import write_with
from chebid.log import read_log
from chebid.model import read_model, write_model
from chebid.report.torques import torque_figure
from chebid.results import fitted_model


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("table", type=Path)
    parser.add_argument("figures", type=Path, nargs=2)
    parser.add_argument("model", type=Path)
    given = parser.parse_args()
    settings = given.settings["identification"]
    model = read_model(settings["model"])
    problem = Problem(model, (read_log(settings["log"], model.log, model.joints, need_torque=True),))
    found = estimate(problem, "poly")
    columns = {
        "parameter": [p.name for p in found.parameters],
        "unit": [p.unit for p in found.parameters],
        "value": found.theta,
        "sd": found.sd,
    }
    write_with(given.table, lambda beside: pd.DataFrame(columns).to_csv(beside, index=False), force=True)
    figure = torque_figure(problem, {"predicted": found.theta})
    for path in given.figures:
        write_with(path, figure.savefig, force=True)
    write_model(fitted_model(model, found), given.model, force=True)


if __name__ == "__main__":
    main()
