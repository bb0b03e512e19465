"""Estimates of every method on many noise seeds: monte_carlo.py SETTINGS MOTION.csv OUT.csv --record NAME --part K.

SETTINGS is JSON with the sections `scara` and `monte_carlo`. Part K of P takes the seeds K, K + P, K + 2 P, ...
"""

import argparse
import json
from pathlib import Path

import pandas as pd
from study import estimates, records, reference, with_prior

from chebid.errors import ChebidError
from chebid.estimators import METHODS, Problem
from chebid.files import write_with
from chebid.model import read_model
from chebid.results import fitted_values

COLUMNS = ["record", "seed", "method", "parameter", "truth", "value", "sd", "sd_eq26", "seconds"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("motion", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--record", required=True)
    parser.add_argument("--part", type=int, required=True)
    given = parser.parse_args()
    own, plan = given.settings["scara"], given.settings["monte_carlo"]
    truth = read_model(own["model"])
    theta = fitted_values(truth)
    motion = reference(pd.read_csv(given.motion), len(truth.joints))
    seeds = range(given.part, plan["seeds"], plan["parts"])
    rows = []
    for seed, log in zip(seeds, records(truth, motion, seeds), strict=True):
        problem = Problem(with_prior(truth, own["prior"], seed), (log,))
        for method, found, seconds in estimates(problem, list(METHODS)):
            if isinstance(found, ChebidError):
                print(f"seed {seed}: {method}: {found}")
                continue
            columns = zip(found.parameters, theta, found.theta, found.sd, found.sd_white, strict=True)
            rows += [(given.record, seed, method, p.name, *numbers, seconds) for p, *numbers in columns]
    table = pd.DataFrame(rows, columns=COLUMNS)
    write_with(given.out, lambda beside: table.to_csv(beside, index=False), force=True)
    print(f"{given.out}: {len(table)} rows")


if __name__ == "__main__":
    main()
