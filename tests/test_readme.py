"""The walk of the README prints today what the README says."""

import re
from pathlib import Path

import pytest
from readme import README, Step, differences, run_all, steps


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[Step, Step]]:
    pasted = steps(README.read_text(encoding="utf-8"))
    return list(zip(pasted, run_all(tmp_path_factory.mktemp("walk")), strict=True))


def test_walk_has_the_whole_path() -> None:
    walk = steps(README.read_text(encoding="utf-8"))
    commands = [step.command.split()[1] for step in walk if step.command.startswith("chebid")]
    assert {"project", "derive", "identify", "predict", "compare", "diagnose", "add", "refine"} <= set(commands)


def test_the_hidden_effect_is_found_in_six_commands() -> None:
    """From the log to the named effect and the lower error."""
    section = README.read_text(encoding="utf-8").split("## Find the missing effect")[1].split("\n## ")[0]
    walk = [step.command.split()[1] for step in steps(section)]
    assert walk[:2] == ["identify", "diagnose"] and len(walk) <= 6


def test_walk_prints_what_the_readme_says(walk: list[tuple[Step, Step]]) -> None:
    wrong = [line for pasted, now in walk for line in differences(pasted, now)]
    assert not wrong, "\n".join([*wrong, "(python -m tests.readme pastes the present output)"])


def test_differences_are_seen() -> None:
    old = Step("x", "value 1.00 N\nname")
    assert not differences(old, Step("x", "value 1.01 N\nname"))
    assert differences(old, Step("x", "value 1.10 N\nname"))
    assert differences(old, Step("x", "value 1.00 m\nname"))
    assert differences(old, Step("x", "value 1.00 N"))


def test_files_named_in_the_readme_exist() -> None:
    root = Path(README).parent
    for name in re.findall(r"\]\(((?!http)[^)#]+)\)|src=\"([^\"]+)\"", README.read_text(encoding="utf-8")):
        path = next(filter(None, name))
        assert (root / path).exists(), path


def test_every_effect_is_in_the_readme() -> None:
    from chebid.effects import LIBRARY

    text = README.read_text(encoding="utf-8")
    missing = [name for name, kind in LIBRARY.items() if f"| `{name}` | {kind.formula} | {kind.sentence} |" not in text]
    assert not missing
