"""The numbers of figures 1 to 5, as CSV: frequency_tables.py KIND SETTINGS OUT.csv [--order K].

KIND is attenuation, derivatives or distortion; SETTINGS is JSON with the sections `projection` and KIND of the
configuration (config/README.md).
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from chebid.basis import Array
from chebid.errors import NoAnswerError
from chebid.files import write_with
from chebid.projection import Operator, Plan
from chebid.response import Response, clock, closed_form, decibel, response


def attenuation(settings: dict[str, Any], order: int) -> pd.DataFrame:
    """Figure 1: every frequency on a record of its own rate; no gain where the degree is too high for the samples."""
    own = settings["attenuation"]
    weight = "legendre" if settings["projection"]["fit"] == "lsq" else settings["projection"]["basis"]
    rows = [
        attenuation_row(settings["projection"], own["points_per_period"], cycles, degree, weight)
        for cycles in steps(own["cycles"])
        for degree in steps(own["degrees"]).astype(int)
    ]
    return pd.DataFrame(rows, columns=["cycles", "degree", "gain_db", "gain_db_whole", "closed_form_db"])


def attenuation_row(projection: dict[str, str], points: float, cycles: float, degree: int, weight: str) -> tuple:
    exact = float(decibel(closed_form(weight, degree, np.pi * cycles)))
    try:
        found = response(Operator(clock(points * cycles, 1.0), Plan(**projection, degree=degree)), cycles)
    except NoAnswerError:
        return cycles, degree, np.nan, np.nan, exact
    return cycles, degree, found.gain_db[0], found.gain_db_whole[0], exact


def derivatives(settings: dict[str, Any], order: int) -> pd.DataFrame:
    """Figures 2 and 4."""
    own = settings["derivatives"]
    f = np.geomspace(own["frequencies"]["start"], own["frequencies"]["stop"], own["frequencies"]["count"])
    exact = order * decibel(2 * np.pi * f)
    parts = []
    for degree in own["degrees"]:
        found = measure(settings["projection"], own, degree, f, order)
        columns = {"exact_db": exact, "rebuilt_db": exact + found.gain_db, "phase_deg": phase(found)}
        parts.append(pd.DataFrame({"degree": degree, "frequency": f, **columns}))
    return pd.concat(parts)


def distortion(settings: dict[str, Any], order: int) -> pd.DataFrame:
    """Figures 3 and 5."""
    own = settings["distortion"]
    f = steps(own["frequencies"])
    parts = []
    for degree in steps(own["degrees"]).astype(int):
        found = measure(settings["projection"], own, degree, f, order)
        parts.append(pd.DataFrame({"frequency": f, "degree": degree, "ratio": np.abs(found.inner)}))
    return pd.concat(parts)


def measure(projection: dict[str, str], own: dict[str, Any], degree: int, f: Array, order: int) -> Response:
    return response(Operator(clock(own["rate"], own["duration"]), Plan(**projection, degree=int(degree))), f, order)


def phase(found: Response) -> Array:
    """From -90 to 270 degrees, so that 180 is not sometimes -180; none where there is next to no output."""
    return np.where(np.abs(found.inner) > 0.01, (found.phase_deg + 90) % 360 - 90, np.nan)


def steps(values: dict[str, float]) -> Array:
    count = int((values["stop"] - values["start"]) / values["step"] + 1e-9) + 1
    return np.round(values["start"] + values["step"] * np.arange(count), 9)


KINDS = {"attenuation": attenuation, "derivatives": derivatives, "distortion": distortion}
DIGITS = {"gain_db": 4, "gain_db_whole": 4, "closed_form_db": 4, "exact_db": 4, "rebuilt_db": 4, "phase_deg": 3}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("out", type=Path)
    parser.add_argument("--order", type=int, default=0)
    given = parser.parse_args()
    table = KINDS[given.kind](given.settings, given.order).round({"ratio": 6, **DIGITS})
    table += 0.0  # no minus zero
    table = table.astype({"degree": int})
    digits = "%.6g" if "frequency" in table else None
    write_with(given.out, lambda beside: table.to_csv(beside, index=False, float_format=digits), force=True)
    print(f"{given.out}: {len(table)} rows")


if __name__ == "__main__":
    main()
