"""One log of the hidden-effect study: hidden_log.py SETTINGS CASE MOTION.csv OTHER.csv OUT.json.

Hides the effect of CASE in an arm, simulates a log along MOTION and a hold-out log along OTHER, and asks `chebid
identify`, `diagnose` and `refine` about them. SETTINGS is JSON with the section `hidden` of the configuration.
"""

import argparse
import json
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from command import chebid
from hiding import case_name, hidden_model, seed_of

from chebid.files import write_with

_JUDGED = ("status", "sure", "effects", "alternatives", "message")
_ATTEMPTS = 3  # seeds tried, where a joint sticks and slips without end


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("case")
    parser.add_argument("motions", type=Path, nargs=2)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    with TemporaryDirectory() as folder:
        found = study(given.settings["hidden"], given.case, given.motions, Path(folder))
    text = json.dumps(found, indent=1, sort_keys=True) + "\n"
    write_with(given.out, lambda beside: Path(beside).write_text(text, encoding="utf-8"), force=True)
    print(f"{given.case}: {found['verdict'].get('message', found['errors'])}")


def study(own: dict[str, Any], case: str, motions: list[Path], folder: Path) -> dict[str, Any]:
    """What was hidden, and what was said about it."""
    effect, size, motion, noise, number = case.split("-")
    assert case == case_name(effect, float(size), motion, noise, int(number)), case
    true, fitted, log, other = (folder / name for name in ("true.yaml", "fitted.yaml", "log.csv", "other.csv"))
    truth = hidden_model(case, Path(own["model"]), motions[0], true)
    said: dict[str, dict[str, Any]] = {}
    for path, along, further in ((log, motions[0], 0), (other, motions[1], 1)):
        for attempt in range(_ATTEMPTS):
            seed = str(seed_of(case) + further + 2 * attempt)
            sizes = ["--rate", str(own["rate"]), "--noise", noise, "--seed", seed]
            made = chebid("simulate", true, along, "-o", path, *sizes)
            if "error" not in made:
                break
        said[f"simulate {path.stem}"] = made
    said["identify"] = chebid("identify", log, "--model", own["given"], "-o", fitted)
    said["diagnose"] = chebid("diagnose", fitted, log, "--holdout", other)
    said["refine"] = chebid("refine", fitted, log, "--holdout", other)
    return {"case": case, "motion": motion, "noise": noise, "truth": truth} | told(said)


def told(said: dict[str, dict[str, Any]]) -> dict[str, Any]:
    """The part of the documents that is judged."""
    diagnosis, refined = said["diagnose"], said["refine"]
    verdict = diagnosis.get("verdict", {})
    steps = refined.get("steps", [])
    return {
        "verdict": {key: verdict[key] for key in _JUDGED if key in verdict},
        "candidates": [[one[key] for key in ("effect", "joint", "score")] for one in diagnosis.get("candidates", [])],
        "depends_on": [[one["joint"], one["variable"]] for one in diagnosis.get("depends_on", [])[:3]],
        "added": [[one["effect"], one["joint"]] for one in refined.get("added", [])],
        "ratio": [step["ratio"] for step in steps],
        "holdout_ratio": [step["holdout_ratio"] for step in steps],
        "errors": {name: one["error"] for name, one in said.items() if "error" in one},
        "seconds": {name: round(one["seconds"], 2) for name, one in said.items()},
    }


if __name__ == "__main__":
    main()
