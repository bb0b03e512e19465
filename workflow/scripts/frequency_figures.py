"""Figures 1 to 5 from their tables: frequency_figures.py KIND SETTINGS TABLE.csv OUT... [--order K]."""

import argparse
import json
from pathlib import Path

import pandas as pd

from chebid.files import write_with
from chebid.report.frequency import attenuation_figure, derivative_figure, distortion_figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("attenuation", "derivatives", "distortion"))
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("table", type=Path)
    parser.add_argument("out", type=Path, nargs="+")
    parser.add_argument("--order", type=int, default=0)
    given = parser.parse_args()
    table, own = pd.read_csv(given.table), given.settings[given.kind]
    if given.kind == "attenuation":
        figure = attenuation_figure(table, own["points_per_period"])
    else:
        draw = derivative_figure if given.kind == "derivatives" else distortion_figure
        figure = draw(table, given.order, own["rate"], own["duration"])
    for out in given.out:
        write_with(out, figure.savefig, force=True)
        print(out)


if __name__ == "__main__":
    main()
