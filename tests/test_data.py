"""The bundled logs are what data/README.md says they are."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest


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
