"""Figure 7 on a record that was not identified on: figure_7.py SETTINGS RECORD.csv OTHER.csv TABLE.csv SVG PNG."""

import argparse
import json
from pathlib import Path

import pandas as pd
from study import identifiable

from chebid.estimators import Problem, estimate, judge
from chebid.files import write_with
from chebid.log import read_log
from chebid.model import read_model
from chebid.report.torques import torque_figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("logs", type=Path, nargs=2)
    parser.add_argument("table", type=Path)
    parser.add_argument("figures", type=Path, nargs=2)
    given = parser.parse_args()
    scara = given.settings["scara"]
    model = identifiable(read_model(scara["model"]), scara["motion"]["rate"])
    own, other = (Problem(model, (read_log(path, model.log, model.joints, need_torque=True),)) for path in given.logs)
    thetas = {method: estimate(own, method).theta for method in ("wls", "poly")}
    rows = [
        (joint, method, r.rms, r.relative, r.relative_raw, r.floor, r.ratio)
        for method, theta in thetas.items()
        for joint, r in judge(other, other.rows, theta).items()
    ]
    table = pd.DataFrame(rows, columns=["joint", "method", "rms", "relative", "relative_raw", "floor", "ratio"])
    write_with(given.table, lambda beside: table.to_csv(beside, index=False, float_format="%.6g"), force=True)
    figure = torque_figure(other, thetas)
    for path in given.figures:
        write_with(path, figure.savefig, force=True)
    print(table.to_string())


if __name__ == "__main__":
    main()
