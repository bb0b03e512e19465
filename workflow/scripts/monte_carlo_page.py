"""The Monte-Carlo page: monte_carlo_page.py SETTINGS CASES.csv PART.csv... --to TABLE.csv SVG PNG MD."""

import argparse
import json
from pathlib import Path

import numpy as np
import pandas as pd
from shown import short

from chebid.files import write_text, write_with
from chebid.report.monte_carlo import monte_carlo_figure

ABOUT = {
    "torque logged early": "The drive runs at 100 Hz and its torque is logged when it is commanded, half a period "
    "before the middle of the time for which it is held. Seen: a viscous friction that is "
    "negative. chebid estimates the lag and warns (`torque_lag`); `log: torque_delay:` in "
    "the model file corrects it.",
    "untrimmed, unweighted": "Degree 125 on the 815 samples of the record, by least squares, all of them used up to "
    "the ends, all rows of the same weight: the accelerations explode at the ends and "
    "nothing is left of the inertias. chebid refuses that degree on so few samples (n is at "
    "most 4 √N), trims the ends, gates and weights.",
    "no gate": "Half a second of rest at every point, where dry friction takes any value up to its "
    "level. chebid leaves out samples whose direction of motion is not known.",
    "degree too small": "A degree on 20 s that would do for 8 s. Seen: friction is wrong, inertia nearly right, "
    "and nothing looks odd. chebid warns before it identifies; the projection of the whole "
    "equation takes what is missing above the band from both sides; left to itself chebid "
    "takes the degree that the record needs.",
    "one weight for all joints": "The torque noises of the joints differ by 10. chebid weights each joint by its "
    "residual.",
    "motion": "The motion of least cond(W) + 1/sigma_min(W) (eq. 23) balances the columns of W by "
    "moving slowly: friction comes out well, and the errors of the inertias are several times those of a motion of "
    "least deviations under the same limits. `chebid excite --information` weighs one against the other.",
    "wide band": "A Duffing oscillator with dry friction (J = 1, Fv = 2, Fs = 5, k = 400, k3 = 4000) "
    "under forces of several widths, projected to 5 Hz. chebid warns before it identifies "
    "(`wide_band`); left to itself it takes a wider band.",
}


def summary(table: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Bias, rmse and mean deviation in % of the truth, and coverages, of each group."""
    size = table.truth.abs()
    error = table.value - table.truth
    parts = table.assign(
        bias=100 * error / size,
        square=(100 * error / size) ** 2,
        sd_percent=100 * table.sd / size,
        covered=error.abs() <= 1.96 * table.sd,
        covered_eq26=error.abs() <= 1.96 * table.sd_eq26,
    ).groupby(keys, sort=False)
    out = parts.agg(
        bias=("bias", "mean"),
        rmse=("square", "mean"),
        sd=("sd_percent", "mean"),
        coverage=("covered", "mean"),
        coverage_eq26=("covered_eq26", "mean"),
        seeds=("seed", "nunique"),
    ).reset_index()
    return out.assign(rmse=np.sqrt(out.rmse))


def named(parts: pd.DataFrame, motions: dict) -> pd.DataFrame:
    """The records by their durations."""
    return parts.assign(record=parts.record.map(lambda name: f"{motions[name]['duration']:g} s"))


def tables(table: pd.DataFrame) -> str:
    """A table for each record and quantity: methods by parameters."""
    heads = {
        "rmse": "rmse, % of the true value",
        "bias": "bias, % of the true value",
        "coverage": "coverage of the 95 % interval from the honest deviation",
        "coverage_eq26": "coverage of the 95 % interval from eq. 26",
    }
    blocks = []
    for record, mine in table.groupby("record", sort=False):
        for what, head in heads.items():
            shown = "{:.2f}".format if what.startswith("coverage") else short
            blocks.append(f"### {record}: {head}\n\n{grid(mine, 'method', lambda row, w=what, s=shown: s(row[w]))}")
    return "\n\n".join(blocks)


def grid(table: pd.DataFrame, key: str, cell) -> str:
    names = list(dict.fromkeys(table.parameter))
    lines = [f"| {key} | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for value, mine in table.groupby(key, sort=False):
        rows = {row["parameter"]: row for _, row in mine.iterrows()}
        lines.append(f"| {value} | " + " | ".join(cell(rows[n]) if n in rows else "" for n in names) + " |")
    return "\n".join(lines)


def cases_text(cases: pd.DataFrame, told: pd.Series) -> str:
    blocks = []
    for case, mine in cases.groupby("case", sort=False):
        shown = mine.assign(variant=[f"{v} (warned: {100 * told[case, v]:.0f} %)" for v in mine.variant])
        body = grid(shown, "variant", biased)
        blocks.append(f"### {case}\n\n{ABOUT[str(case)]}\n\nBias (rmse), % of the true value:\n\n{body}")
    return "\n\n".join(blocks)


def biased(row: pd.Series) -> str:
    return "refused" if np.isnan(row["bias"]) else f"{short(row['bias'])} ({short(row['rmse'])})"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("cases", type=Path)
    parser.add_argument("parts", type=Path, nargs="+")
    parser.add_argument("--to", type=Path, nargs=4, required=True)
    given = parser.parse_args()
    own = given.settings["scara"]
    estimates = pd.concat([pd.read_csv(path) for path in given.parts]).sort_values("seed", kind="stable")
    estimates = named(estimates, own["motions"])
    main_table = summary(estimates, ["record", "method", "parameter"])
    raw = pd.read_csv(given.cases)
    cases, told = summary(raw, ["case", "variant", "parameter"]), raw.groupby(["case", "variant"]).warned.mean()
    csv, *pictures, md = given.to
    both = pd.concat(
        [
            main_table.assign(study=main_table.record + ", " + main_table.method),
            cases.assign(study=cases.case + ": " + cases.variant),
        ]
    )[["study", "parameter", "bias", "rmse", "sd", "coverage", "coverage_eq26", "seeds"]]
    write_with(csv, lambda beside: both.to_csv(beside, index=False, float_format="%.5g"), force=True)
    figure = monte_carlo_figure(main_table)
    for path in pictures:
        write_with(path, figure.savefig, force=True)
    count = given.settings["monte_carlo"]["seeds"]
    text = (
        f"# Monte-Carlo\n\nThe paper's robot in closed loop, {own['motion']['rate']:g} samples per second, {count} "
        f"noise seeds per record; the prior of `ekf` is off by up to {100 * own['prior']:g} %.\n\n"
        "![rmse and coverage](monte_carlo.svg)\n\n"
        f"## Six estimators\n\n{tables(main_table)}\n\n## Pitfalls: what is seen, and what chebid does about it\n\n"
        f"{cases_text(cases, told)}\n"
    )
    write_text(md, text, force=True)
    print(f"{csv}: {len(both)} rows")


if __name__ == "__main__":
    main()
