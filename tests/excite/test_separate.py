"""`chebid excite --separate`: what it refuses, what it writes, and that its motions do what they are for."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from command import chebid
from rigs import CONTROL, TRUE

from chebid.errors import NoAnswerError, UsageError
from chebid.excite import separate
from chebid.excite.fourier import Fourier
from chebid.excite.limits import Limits
from chebid.model import Model, read_model

SCARA = {
    "robot": {"type": "scara"},
    "joints": ["q1", "q2"],
    "effects": ["viscous", "coulomb"],
    "control": CONTROL,
    "sensors": {"encoder": 1.6e-4, "torque_noise": [0.25, 0.025]},
    "limits": {"position": [1.5, 2.2], "velocity": [4.0, 8.0], "acceleration": [12.0, 40.0]},
}
RAIL = {
    "robot": {"type": "axes", "types": ["prismatic"]},
    "joints": ["x"],
    "effects": ["viscous", "coulomb"],
    "limits": {"position": 0.2, "velocity": 0.5, "acceleration": 3.0},
}
SHORT: dict[str, Any] = {"duration": 6.0, "moves": 6, "starts": 1}


def fitted(data: dict[str, Any], **values: float) -> dict[str, Any]:
    """A model file with given parameters, as if identified."""
    return data | {"fit": {"method": "poly", "parameters": {name: {"value": v} for name, v in values.items()}}}


def write(path: Path, data: dict[str, Any]) -> Path:
    path.write_text(yaml.safe_dump(data))
    return path


# what it refuses ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("names", "error", "match"),
    [
        (["stribeck:q2"], UsageError, "two different effects"),
        (["stribeck:q2", "stribeck:q2"], UsageError, "two different effects"),
        (["stribeck", "spring:q2"], UsageError, "on which joint"),
        (["stribek:q2", "spring:q2"], UsageError, "unknown effect 'stribek'"),
        (["stribeck:q3", "spring:q2"], UsageError, "no joint 'q3'"),
        (["payload:q2", "spring:q2"], UsageError, "the whole arm"),
        (["coulomb:q2", "spring:q2"], UsageError, "has coulomb:q2 already"),
        (["external_push:q2", "spring:q2"], NoAnswerError, "happens once"),
        (["saturation:q2", "spring:q2"], NoAnswerError, "shows in the torque"),
        (["rotor_inertia:q1", "spring:q2"], NoAnswerError, "no motion tells it from ZZR1"),
        (["load_friction:q2", "spring:q2"], NoAnswerError, "not known yet"),
    ],
)
def test_refuses_what_cannot_be(names: list[str], error: type[Exception], match: str) -> None:
    with pytest.raises(error, match=match):
        separate(Model.model_validate(SCARA), names, **SHORT)


def test_the_gain_of_the_only_joint_is_in_all_parameters() -> None:
    model = Model.model_validate(fitted(RAIL, M1=2.0, Fv1=1.0, Fs1=0.5))
    with pytest.raises(NoAnswerError, match="torque_gain:x: no motion tells it from M1, Fv1, Fs1"):
        separate(model, ["torque_gain", "spring"], **SHORT)


def test_rivals_that_say_the_same_are_refused() -> None:
    with pytest.raises(NoAnswerError, match="offset:x and base_tilt say the same on every motion"):
        separate(Model.model_validate(RAIL), ["offset", "base_tilt"], **SHORT)


def test_a_rival_that_contains_another_is_told() -> None:
    found = separate(Model.model_validate(RAIL), ["offset", "spring"], **SHORT)
    (notice,) = [notice for notice in found.notices if notice.kind == "contained"]
    assert notice.message.startswith("spring:x can be all that offset:x is")


def test_a_record_too_short_for_a_difference() -> None:
    """11 samples, in which rivals as strong as the noise differ by less than a unit of log likelihood."""
    rail = Model.model_validate(RAIL)
    with pytest.raises(NoAnswerError, match="no motion was found within the limits") as caught:
        separate(rail, ["stribeck", "viscous_quadratic"], duration=1.0, rate=10.0, moves=1, starts=1)
    assert "--duration" in caught.value.hint


def test_a_record_that_is_not_enough_is_said_to_be() -> None:
    found = separate(Model.model_validate(RAIL), ["spring", "hard_stop"], duration=2.0, rate=50.0, moves=3, starts=1)
    (notice,) = found.notices
    assert 1 < found.least < 24
    assert f"record it {int(np.ceil(24 / found.least))} times" in notice.message


@pytest.mark.parametrize(
    ("arguments", "match"),
    [
        (["spring:q2"], "unexpected argument 'spring:q2'"),
        (["--log", "a.csv"], "--log is given without --separate"),
        (["--separate", "spring:q2", "offset:q2", "--information", "1"], "goes with eq. 23"),
    ],
)
def test_options_that_do_not_go_together(tmp_path: Path, arguments: list[str], match: str) -> None:
    answer = chebid("excite", write(tmp_path / "arm.yaml", SCARA), *arguments, "-o", tmp_path / "t.csv")
    assert answer.status == 2
    assert match in answer.error


# what it writes -------------------------------------------------------------------------------------------------------


def test_the_trajectory_keeps_its_limits_and_repeats(tmp_path: Path) -> None:
    model = write(tmp_path / "arm.yaml", SCARA)
    names = ["viscous_quadratic:q2", "viscous_power:q2"]
    short = ["--duration", 6, "--moves", 6, "--starts", 1]
    first = chebid("excite", model, "--separate", *names, *short, "-o", tmp_path / "a.csv", "--json")
    second = chebid("excite", "--separate", *names, model, *short, "-o", tmp_path / "b.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()
    table = pd.read_csv(tmp_path / "a.csv")
    for order, key in (("", "position"), ("d", "velocity"), ("dd", "acceleration")):
        largest = table[[f"{order}q1", f"{order}q2"]].abs().max().to_numpy()
        assert (largest <= SCARA["limits"][key]).all()
    document = first.document
    (pair,) = document["pairs"]
    assert pair["rivals"] == names
    assert document["before_motion"] == "random"
    assert pair["after"] == document["separability"] >= pair["before"] > 0
    assert {entry["rival"] for entry in document["assumed"]} == set(names)
    assert f"{pair['after']:.3g}" in second.out


# what it is for -------------------------------------------------------------------------------------------------------


def ordinary(path: Path) -> Path:
    """A random Fourier series that stays slow and in the middle of the range."""
    narrow = Limits(np.array([1.0, 0.9]), np.array([2.0, 3.0]), np.array([8.0, 20.0]))
    family, t = Fourier(narrow, 10.0, 9), np.arange(1001) / 100
    state = family.motion(family.random(np.random.default_rng(1)), t)
    names = [f"{order}q{j}" for order in ("", "d", "dd") for j in (1, 2)]
    pd.DataFrame(np.column_stack([t, *state]), columns=["t", *names]).to_csv(path, index=False)
    return path


def run(*arguments: object) -> Any:
    answer = chebid(*arguments, "--json")
    assert answer.status == 0, answer.err
    return json.loads(answer.out)


CASES = [
    ({"effect": "stribeck", "joint": "q2", "vs": 0.8}, {"Fst2": 0.08}, "viscous_quadratic"),
    ({"effect": "spring", "joint": "q2"}, {"k2": 0.03, "kq02": -0.015}, "hard_stop"),
]


@pytest.mark.parametrize(("entry", "values", "rival"), CASES, ids=lambda x: x if isinstance(x, str) else "")
def test_rivals_are_told_apart(tmp_path: Path, entry: dict[str, Any], values: dict[str, float], rival: str) -> None:
    """Alternatives on an ordinary log; with one more log, along the motion that was made for it, no longer."""
    truth = entry["effect"]
    hidden = SCARA | {"effects": [*SCARA["effects"], entry]}
    true = write(tmp_path / "true.yaml", fitted(hidden, **TRUE | values))
    base = write(tmp_path / "base.yaml", SCARA)
    old, new, model = tmp_path / "old.csv", tmp_path / "new.csv", tmp_path / "fitted.yaml"
    run("simulate", true, ordinary(tmp_path / "ordinary.csv"), "-o", old, "--seed", 1)
    run("identify", old, "--model", base, "-o", model)
    before = run("diagnose", model, old)
    assert gap(before, truth, rival) < 24
    short = ["--duration", 12, "--moves", 8, "--starts", 1]
    found = run("excite", model, "--separate", f"{truth}:q2", f"{rival}:q2", *short, "-o", tmp_path / "separate.csv")
    assert found["before_motion"] == "log"
    assert {entry["from"] for entry in found["assumed"]} == {"log"}
    assert found["separability"] > 5 * max(found["pairs"][0]["before"], 1.0)
    run("simulate", true, tmp_path / "separate.csv", "-o", new, "--seed", 2)
    run("identify", old, new, "--model", base, "-o", tmp_path / "both.yaml")
    after = run("diagnose", tmp_path / "both.yaml", old, new)
    assert after["verdict"]["effects"] == [{"effect": truth, "joint": "q2"}]
    assert {"effect": rival, "joint": "q2"} not in after["verdict"]["alternatives"]
    assert gap(after, truth, rival) > 24


def gap(document: Any, truth: str, rival: str) -> float:
    """Score of the truth less that of its rival; what is not listed scores less than what is."""
    scores = {entry["effect"]: entry["score"] for entry in document["candidates"] if entry["joint"] == "q2"}
    return scores[truth] - scores.get(rival, min(scores.values()))


def test_the_log_of_the_fit_is_found_beside_the_model_only_unchanged(tmp_path: Path, project: Path) -> None:
    from chebid.excite.size import find_logs

    log = tmp_path / "scara.csv"
    log.write_bytes((project / "data" / "scara.csv").read_bytes())
    run("identify", log, "--model", project / "data" / "scara.yaml", "-o", tmp_path / "fitted.yaml")
    model = read_model(tmp_path / "fitted.yaml")
    assert find_logs(model) == [log]
    log.write_text(log.read_text() + "\n")
    assert find_logs(model) == []
