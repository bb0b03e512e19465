"""An exciting motion of the SCARA: motion.py SETTINGS NAME OUT.csv; SETTINGS is JSON with the section `scara`."""

import argparse
import json
from pathlib import Path

from study import find_motion

from chebid.files import write_with
from chebid.model import read_model


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("name")
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    own = given.settings["scara"]
    table = find_motion(read_model(own["model"]), own["motion"], **own["motions"][given.name])
    write_with(given.out, lambda beside: table.to_csv(beside, index=False), force=True)
    print(f"{given.out}: {len(table)} samples")


if __name__ == "__main__":
    main()
