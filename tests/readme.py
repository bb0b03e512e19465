"""The README's walk: its commands, their pasted output, and how to paste it anew.

python -m tests.readme        runs every `$ chebid ...` of the README in a scratch folder and pastes what it prints
"""

import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
BLOCK = re.compile(r"```console\n(.*?)```", re.DOTALL)
_NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


@dataclass(frozen=True)
class Step:
    """A command and what the README says it prints."""

    command: str
    printed: str


def steps(text: str) -> list[Step]:
    """The commands of all console blocks, in order."""
    out = []
    for block in BLOCK.findall(text):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, printed = part.partition("\n")
            out.append(Step(command, printed.rstrip("\n")))
    return out


def run_all(folder: Path) -> list[Step]:
    """Run the walk in a folder that has a copy of data/ and config/; the steps with what they print now."""
    for name in ("data", "config"):
        shutil.copytree(ROOT / name, folder / name)
    return [Step(step.command, _run(step.command, folder)) for step in steps(README.read_text(encoding="utf-8"))]


def _run(command: str, folder: Path) -> str:
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    environment = os.environ | {"PATH": path, "NO_COLOR": "1", "COLUMNS": "120"}
    done = subprocess.run(
        command, shell=True, cwd=folder, capture_output=True, text=True, env=environment, check=False, timeout=300
    )
    return "\n".join(line.rstrip() for line in (done.stderr + done.stdout).rstrip("\n").split("\n"))


def differences(pasted: Step, now: Step, tolerance: float = 0.02) -> list[str]:
    """Lines that differ in their words, or in a number by more than the tolerance (relative; 0.02 of the last digit
    printed is rounding on another processor).
    """
    old, new = pasted.printed.split("\n"), now.printed.split("\n")
    if len(old) != len(new):
        return [f"{pasted.command}: {len(old)} lines in the README, {len(new)} now"]
    return [f"{a!r} is now {b!r}" for a, b in zip(old, new, strict=True) if not _alike(a, b, tolerance)]


def _alike(a: str, b: str, tolerance: float) -> bool:
    if re.sub(r"\s+", " ", _NUMBER.sub("#", a)) != re.sub(r"\s+", " ", _NUMBER.sub("#", b)):
        return False
    pairs = zip(map(float, _NUMBER.findall(a)), map(float, _NUMBER.findall(b)), strict=True)
    return all(abs(x - y) <= tolerance * max(abs(x), abs(y)) for x, y in pairs)


def main() -> None:
    """Paste the present output."""
    text = README.read_text(encoding="utf-8")
    with TemporaryDirectory() as folder:
        for old, new in zip(steps(text), run_all(Path(folder)), strict=True):
            before = f"$ {old.command}\n{old.printed}".rstrip("\n") + "\n"
            after = f"$ {new.command}\n{new.printed}".rstrip("\n") + "\n"
            assert before in text, before
            text = text.replace(before, after, 1)
    README.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
