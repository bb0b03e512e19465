"""An exciting motion of the SCARA: motion.py SETTINGS NAME OUT.csv; SETTINGS is JSON with the section `scara`.

Motions that were found are kept in data/motions.yaml, beside the settings that they were found with: rounding, which
is not the same on all processors, leads the search to other motions that are as good. A motion with other settings, or
of a model with other limits or effects, is searched anew; --keep searches in any case, and keeps what it finds.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from study import find_motion, sampled

from chebid.files import write_with
from chebid.model import Model, read_model

KEPT = Path(__file__).resolve().parents[2] / "data" / "motions.yaml"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("name")
    parser.add_argument("out", type=Path)
    parser.add_argument("--keep", action="store_true")
    given = parser.parse_args()
    own = given.settings["scara"]
    model = read_model(own["model"])
    wanted = own["motion"] | own["motions"][given.name] | depends_on(model)
    kept = yaml.safe_load(KEPT.read_text(encoding="utf-8"))
    if given.keep or kept.get(given.name, {}).get("settings") != wanted:
        points, durations = find_motion(model, own["motion"], **own["motions"][given.name])
    else:
        points, durations = (np.array(kept[given.name][part]) for part in ("points", "durations"))
        print(f"{given.name}: the motion kept in {KEPT}")
    if given.keep:
        keep(kept | {given.name: {"settings": wanted, "points": points.tolist(), "durations": durations.tolist()}})
    table = sampled(model, points, durations, own["motion"]["rate"])
    write_with(given.out, lambda beside: table.to_csv(beside, index=False), force=True)
    print(f"{given.out}: {len(table)} samples")


def depends_on(model: Model) -> dict[str, Any]:
    """What a search takes from the model."""
    limits = model.limits.model_dump(mode="json", exclude_none=True) if model.limits else {}
    return {"robot": model.robot.type, "effects": [spec.effect for spec in model.effects], "limits": limits}


def keep(motions: dict[str, Any]) -> None:
    text = yaml.safe_dump(motions, default_flow_style=None, sort_keys=False, width=120)
    write_with(KEPT, lambda beside: beside.write_text(text, encoding="utf-8"), force=True)


if __name__ == "__main__":
    main()
