"""A table that was made against the committed one: check.py TABLE.csv REFERENCE.csv SETTINGS OUT.txt.

SETTINGS is JSON with the sections `tolerance` and `accept` of the configuration. Rows are matched by their first two
columns; numbers beyond the tolerance end the script with status 1. A coverage is a count over noise seeds: two seeds
more or less may lie within their intervals, because on another processor a last digit can put them there.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd

SEEDS = 2


def chance(name: str, reference: pd.DataFrame) -> np.ndarray:
    """By how much the rows (N,) of a column may differ beyond the tolerance."""
    counted = name.startswith("coverage") and "seeds" in reference
    return SEEDS / reference["seeds"].to_numpy(float) + 1e-9 if counted else np.zeros(len(reference))


def compare(made: pd.DataFrame, reference: pd.DataFrame, absolute: float, relative: float) -> tuple[str, bool]:
    """A sentence, and whether the tables agree."""
    if list(made.columns) != list(reference.columns):
        return f"columns {', '.join(made)} instead of {', '.join(reference)}", False
    words = [name for name in made.columns[2:] if not pd.api.types.is_numeric_dtype(made[name])]
    keys = [*made.columns[:2], *words]
    values = [name for name in made.columns if name not in keys]
    both = made.round({key: 6 for key in keys}).merge(
        reference.round({key: 6 for key in keys}), on=keys, suffixes=("", "_committed")
    )
    if both.empty:
        return "no row in common with the committed table", False
    worst, share, where = 0.0, 0.0, "-"
    for name in values:
        a, b = both[name].to_numpy(float), both[f"{name}_committed"].to_numpy(float)
        lost = np.isnan(a) != np.isnan(b)
        difference = np.where(lost, np.inf, np.nan_to_num(np.abs(a - b)))
        allowed = absolute + relative * np.nan_to_num(np.abs(b)) + chance(name, both)
        used = difference / (allowed + 1e-300)
        if used.max() > share:
            row = int(np.argmax(used))
            worst, share = float(difference[row]), float(used[row])
            where = f"{name} at " + ", ".join(f"{key} = {both[key][row]}" for key in keys)
    text = f"{len(both)} of {len(made)} rows compared"
    if share == 0:
        return f"{text}: the same", True
    return f"{text}; largest difference {worst:.3g} ({where}), {share:.3g} times the tolerance", share <= 1


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", type=Path)
    parser.add_argument("reference", type=Path)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    if not given.reference.exists():
        text, agree = f"{given.reference} does not exist yet: nothing to compare with", True
    else:
        text, agree = compare(pd.read_csv(given.table), pd.read_csv(given.reference), **given.settings["tolerance"])
    if not agree and given.settings["accept"]:
        text, agree = f"{text}; accepted all the same", True
    if not agree:
        print(f"error: {given.table} differs from {given.reference}: {text}")
        print("hint: if the change is meant: snakemake --config accept=true, look at the figures, and commit them")
        return 1
    given.out.write_text(f"{given.table.name}: {text}\n", encoding="utf-8")
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
