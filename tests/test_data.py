"""The bundled logs are what data/README.md says they are."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from chebid.model import read_model


def commands(project: Path) -> list[list[str]]:
    """The commands of data/README.md that simulate."""
    text = (project / "data/README.md").read_text(encoding="utf-8")
    return [line.split() for line in text.splitlines() if line.startswith("chebid simulate")]


def test_every_log_has_its_command(project):
    made = {command[command.index("-o") + 1] for command in commands(project)}
    assert made == {"data/scara.csv", "data/scara_other.csv"}


@pytest.mark.parametrize("number", [0, 1])
def test_logs_come_out_again(project, tmp_path, number):
    command = commands(project)[number]
    place = command.index("-o") + 1
    kept, again = project / command[place], tmp_path / "log.csv"
    command[place] = str(again)
    call = [sys.executable, "-c", "from chebid.cli import main; main()", *command[1:], "--quiet"]
    subprocess.run(call, cwd=project, check=True, capture_output=True)
    assert_same_log(kept, again)


def truth(project: Path) -> dict:
    return yaml.safe_load((project / "data/hidden_truth.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_logs_with_hidden_effects_come_out_again(project, tmp_path, number):
    script = project / "workflow/scripts/hidden_data.py"
    arguments = ["data/hidden_truth.yaml", "config/scara.yaml", tmp_path, f"hidden_{number}"]
    environment = os.environ | {"PYTHONPATH": str(project)}
    subprocess.run([sys.executable, script, *arguments], cwd=project, check=True, capture_output=True, env=environment)
    for name in (f"hidden_{number}.csv", f"hidden_{number}_other.csv"):
        assert_same_log(project / "data" / name, tmp_path / name)


def test_hidden_effects_are_as_strong_as_they_say(project):
    """And the model file that a reader starts from does not have them; one log has nothing."""
    given = read_model(project / "data/scara.yaml")
    effects = [own["effects"] for own in truth(project).values()]
    assert [len(one) for one in effects] == [1, 1, 1, 0]
    assert not {spec.effect for spec in given.effects} & {entry["effect"] for one in effects for entry in one}
    assert all(1 <= own["strength"] <= 2 for own in truth(project).values() if own["effects"])


def test_the_truth_is_not_told_elsewhere(project):
    """Neither by the page about the logs nor by anything beside them."""
    told = (project / "data/README.md").read_text(encoding="utf-8")
    for own in truth(project).values():
        for entry in own["effects"]:
            assert entry["effect"] not in told
    assert sum(path.stat().st_size for path in (project / "data").iterdir()) < 2e6


def assert_same_log(kept: Path, again: Path) -> None:
    old, new = pd.read_csv(kept), pd.read_csv(again)
    assert list(old) == list(new)
    assert len(old) == len(new)
    # another processor rounds differently: an encoder may then show the next count now and then, no more
    count = 1.6e-4
    for name in ("q1", "q2"):
        apart = np.abs(old[name] - new[name])
        assert apart.max() <= 1.01 * count
        assert np.mean(apart > 1e-6) < 0.01
    for name, noise in (("tau1", 0.25), ("tau2", 0.025)):
        assert np.mean(np.abs(old[name] - new[name]) > noise) < 0.05
