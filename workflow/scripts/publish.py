"""Put files beside the committed ones: publish.py MADE... --to KEPT... [--accept].

A kept file stays as it is, since its numbers agree with those made (check.py), unless it is missing or --accept is
given: a run on another machine does not change what git sees.
"""

import argparse
import os
import shutil
from pathlib import Path

from chebid.files import write_with


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("made", type=Path, nargs="+")
    parser.add_argument("--to", type=Path, nargs="+", required=True, dest="kept")
    parser.add_argument("--accept", action="store_true")
    given = parser.parse_args()
    for made, kept in zip(given.made, given.kept, strict=True):
        if kept.exists() and not given.accept:
            os.utime(kept)
            print(f"{kept}: kept")
        else:
            write_with(kept, lambda beside, source=made: shutil.copyfile(source, beside), force=True)
            print(f"{kept}: replaced by {made}")


if __name__ == "__main__":
    main()
