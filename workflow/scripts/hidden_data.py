"""The bundled logs with hidden effects: hidden_data.py TRUTH.yaml MODEL.yaml FOLDER [NAME...].

Writes FOLDER/NAME.csv and FOLDER/NAME_other.csv for every log of the truth: the arm of MODEL with the truth's effects
and numbers, through `chebid simulate`.
"""

import argparse
import copy
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml
from command import chebid


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("truth", type=Path)
    parser.add_argument("model", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("names", nargs="*")
    given = parser.parse_args()
    truth, arm = (yaml.safe_load(path.read_text(encoding="utf-8")) for path in (given.truth, given.model))
    for name, own in truth.items():
        if not given.names or name in given.names:
            make(own, arm, given.truth.parent, given.folder / name)


def make(own: dict[str, Any], arm: dict[str, Any], motions: Path, out: Path) -> None:
    """The log and its hold-out log, `out` being their path without suffix."""
    model = copy.deepcopy(arm)
    model["effects"] += own["effects"]
    model["fit"]["parameters"] = own["parameters"]
    with TemporaryDirectory() as folder:
        path = Path(folder, "arm.yaml")
        path.write_text(yaml.safe_dump(model), encoding="utf-8")
        for suffix, along in (("", own["log"]), ("_other", own["other"])):
            log = out.with_name(f"{out.name}{suffix}.csv")
            options = ["--rate", "100", "--noise", own["noise"], "--seed", str(along["seed"]), "--force"]
            made = chebid("simulate", path, motions / along["motion"], "-o", log, *options)
            assert "error" not in made, made["error"]


if __name__ == "__main__":
    main()
