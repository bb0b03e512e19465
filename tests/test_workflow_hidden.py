"""The hidden-effect study: what is hidden, how it is judged, and what is shown of it."""

import json
import sys
from collections import Counter
from pathlib import Path

import pandas as pd
import pytest
import yaml

from chebid.effects import LIBRARY, make_effects
from chebid.model import read_model
from chebid.results import fitted_values

ROOT = Path(__file__).resolve().parents[1]
ARM, MOTION = ROOT / "config/scara.yaml", ROOT / "data/hidden_motion_1.csv"


def settings(*names: str) -> dict:
    """The section `hidden` of paper.yaml with these laid over it."""
    out: dict = {}
    for name in ("paper", *names):
        out |= yaml.safe_load((ROOT / "config" / f"{name}.yaml").read_text(encoding="utf-8"))["hidden"]
    return out


# --- what is hidden


def test_every_effect_is_hidden_as_strongly_as_it_says(script, tmp_path: Path) -> None:
    hiding = script("hiding")
    for effect in hiding.DRAWS:
        path = tmp_path / f"{effect}.yaml"
        truth = hiding.hidden_model(f"{effect}-1.5-fourier-white-0", ARM, MOTION, path)
        assert truth["effect"] == effect
        assert hiding.strength(path, MOTION) == pytest.approx(1.5, rel=2e-3), effect  # numbers have 4 or 5 digits
        model = read_model(path)
        assert [one.name for one in make_effects(model)][4:] == [effect]
        assert len(fitted_values(model)) == 8 + len(truth["values"])


def test_a_case_is_the_same_wherever_it_is_drawn(script, tmp_path: Path) -> None:
    hiding = script("hiding")
    texts = []
    for case in ("stribeck-1-points-white-0", "stribeck-1-points-white-0", "stribeck-1-points-white-1"):
        hiding.hidden_model(case, ARM, MOTION, tmp_path / "arm.yaml")
        texts.append((tmp_path / "arm.yaml").read_text(encoding="utf-8"))
    assert texts[0] == texts[1] != texts[2]


def test_nothing_is_hidden_where_nothing_is_to_be(script, tmp_path: Path) -> None:
    truth = script("hiding").hidden_model("nothing-0-points-white-0", ARM, MOTION, tmp_path / "arm.yaml")
    assert truth["effect"] == "nothing"
    assert len(make_effects(read_model(tmp_path / "arm.yaml"))) == 4  # viscous and Coulomb, on two joints


def test_bundled_logs_hide_what_their_truth_says(script, tmp_path: Path) -> None:
    hiding, arm = script("hiding"), yaml.safe_load(ARM.read_text(encoding="utf-8"))
    truth = yaml.safe_load((ROOT / "data/hidden_truth.yaml").read_text(encoding="utf-8"))
    for name, own in truth.items():
        arm["effects"] = ["viscous", "coulomb", *own["effects"]]
        arm["fit"]["parameters"] = own["parameters"]
        (tmp_path / "arm.yaml").write_text(yaml.safe_dump(arm), encoding="utf-8")
        found = hiding.strength(tmp_path / "arm.yaml", ROOT / "data" / own["log"]["motion"])
        assert found == pytest.approx(own["strength"], rel=2e-3, abs=1e-9), name


def test_the_studies_are_parts_of_each_other(script) -> None:
    """So that a log of one is the same log in another."""
    hiding = script("hiding")
    whole, small, tiny = (hiding.cases(settings(*names)) for names in (["study"], [], ["quick"]))
    assert len(whole) == len(set(whole)) == 24 * 3 * 4 + 60
    assert (len(small), len(tiny)) == (24, 2)
    assert set(small) | set(tiny) <= set(whole)
    assert len({motion for case in tiny for motion in hiding.motions_of(case, settings("quick"))}) == 2  # soon found
    shared = ("model", "given", "rate", "motion", "motions", "pool", "noises")
    assert all(settings(name)[key] == settings()[key] for name in ("study", "quick") for key in shared)
    assert set(settings("study")["effects"]) == set(hiding.DRAWS) <= set(LIBRARY)
    for part in (2, 3):  # kinds of motion, and of noise
        counts = Counter(case.split("-")[part] for case in whole)
        assert len(counts) == 2 and len(set(counts.values())) == 1


def test_the_hold_out_is_of_another_kind(script) -> None:
    hiding, own = script("hiding"), settings("study")
    for case in hiding.cases(own):
        mine, other = hiding.motions_of(case, own)
        assert mine.split("_")[1] == case.split("-")[2] != other.split("_")[1]
        assert max(int(name.split("_")[2]) for name in (mine, other)) < own["pool"]


# --- how it is judged


def log(
    truth: tuple[str, str | None], *said: tuple[str, str | None], sure: bool = True, status: str = "missing"
) -> dict:
    """What hidden_log.py writes: named is the first of `said`, the others are its rivals."""
    first, *rivals = [{"effect": effect, "joint": joint} for effect, joint in said] or [None]
    verdict = {"status": status, "sure": sure, "effects": [first] if first else [], "alternatives": rivals}
    return {
        "case": "x", "motion": "points", "noise": "white", "errors": {}, "seconds": {"diagnose": 1.0, "refine": 2.0},
        "truth": {"effect": truth[0], "joint": truth[1], "strength": 0.0 if truth[0] == "nothing" else 1.0},
        "verdict": verdict,
        "ratio": [{"q1": 1.0, "q2": 3.0}, {"q1": 1.1, "q2": 0.9}],
        "holdout_ratio": [{"q1": 1.0, "q2": 4.0}, {"q1": None, "q2": 1.2}],
    }  # fmt: skip


LOGS = [
    log(("stribeck", "q2"), ("stribeck", "q2")),
    log(("stribeck", "q2"), ("stribeck", "q1"), ("stribeck", "q2"), sure=False),
    log(("spring", "q1"), ("hard_stop", "q1")),
    log(("payload", None), ("payload", None)),
    log(("torque_gain", "q2"), ("torque_gain", "q1"), sure=False),  # the same as on the other joint
    log(("nothing", None), status="nothing_missing"),
    log(("nothing", None), ("spring", "q2")),
    log(("nothing", None), status="unknown", sure=False),
    log(("spring", "q1"), ("spring", "q1")) | {"verdict": {}, "ratio": [], "holdout_ratio": []},
]


def test_right_and_wrong(script) -> None:
    rows = pd.DataFrame([script("hidden_pages").judged(one) for one in LOGS])
    assert list(rows.right) == [True, False, False, True, True, True, False, False, False]
    assert list(rows["among"][:5]) == [True, True, False, True, True]
    expected = ["stribeck", "other joint", "hard_stop", "payload", "torque_gain", "nothing", "spring", "unknown"]
    assert list(rows.named) == [*expected, "no answer"]
    assert rows.ratio_before[0] == 3.0 and rows.ratio_after[0] == 1.1
    assert rows.holdout_ratio_before[0] == 4.0 and rows.holdout_ratio_after[0] == 1.2


def test_summary_of_known_verdicts(script, tmp_path: Path, monkeypatch) -> None:
    """Through the script, as in the workflow."""
    files = []
    for number, one in enumerate(LOGS):
        files.append(tmp_path / f"{number}.json")
        files[-1].write_text(json.dumps(one), encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["hidden_pages", str(tmp_path), *map(str, files)])
    script("hidden_pages").main()
    numbers = pd.read_csv(tmp_path / "hidden_summary.csv").set_index("hidden")
    every, nothing = numbers.loc["every strength"], numbers.loc["nothing hidden"]
    assert every["logs"] == 6 and every["no answer"] == 1
    assert every["right first"] == pytest.approx(60) and every["among"] == pytest.approx(80)
    assert every["sure and right"] == pytest.approx(200 / 3)
    assert nothing["false alarms"] == pytest.approx(200 / 3)
    assert every["hold-out after"] == 1.2
    page = (tmp_path / "hidden_summary.md").read_text(encoding="utf-8")
    assert {line.count("|") for line in page.splitlines() if line.startswith("|")} == {5}
    assert "| false alarms |  |  | 66.7 |" in page
    shares = pd.read_csv(tmp_path / "hidden_accuracy.csv").set_index("effect")
    assert list(shares.loc["stribeck", ["right", "logs"]]) == [1, 2]
    assert pd.read_csv(tmp_path / "hidden_confusion.csv").logs.sum() == 8
    for name in ("accuracy", "confusion"):
        assert (tmp_path / f"hidden_{name}.png").stat().st_size > 10_000


def test_a_command_that_fails_is_told(script, tmp_path: Path) -> None:
    found = script("command").chebid("identify", tmp_path / "none.csv", "--model", ROOT / "data/scara.yaml")
    assert found["error"].startswith("error: ") and found["seconds"] > 0


def test_captions_exist(script) -> None:
    for name in ("accuracy", "confusion", "summary", "strip"):
        assert (ROOT / "workflow/report" / f"hidden_{name}.rst").read_text(encoding="utf-8").count("**") >= 2
