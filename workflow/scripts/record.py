"""A closed-loop record of the SCARA: record.py SETTINGS MOTION.csv OUT.csv; SETTINGS holds the section `scara`."""

import argparse
import json
from pathlib import Path

import pandas as pd
from study import reference

from chebid.files import write_with
from chebid.model import read_model
from chebid.results import fitted_values
from chebid.simulate import simulate, simulated_table


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("motion", type=Path)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    own = given.settings["scara"]
    model = read_model(own["model"])
    motion = reference(pd.read_csv(given.motion), len(model.joints))
    made = simulate(model, fitted_values(model), motion, seed=own["seed"])
    table = simulated_table(made, reference=True)
    write_with(given.out, lambda beside: table.to_csv(beside, index=False), force=True)
    print(f"{given.out}: {len(table)} samples, furthest from the reference: {made.largest_error}")


if __name__ == "__main__":
    main()
