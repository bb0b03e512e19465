"""Table 1, figure 7 and the Monte-Carlo page: their scripts on small inputs, against what is known."""

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

from chebid.model import read_model
from chebid.results import fitted_values
from chebid.simulate import Reference

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def settings() -> dict:
    return yaml.safe_load((ROOT / "config" / "paper.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def truth():
    return read_model(ROOT / "config" / "scara.yaml")


def move(duration: float = 1.0, rate: float = 100.0) -> Reference:
    """One move of both joints and back."""
    t = np.arange(round(2 * duration * rate) + 1) / rate
    x = np.where(t <= duration, t, 2 * duration - t) / duration
    sign = np.where(t <= duration, 1.0, -1.0)
    s, ds, dds = x**3 * (10 - 15 * x + 6 * x**2), 30 * x**2 * (1 - x) ** 2, 60 * x * (1 - x) * (1 - 2 * x)
    columns = [np.column_stack([y, 2 * y]) for y in (s, sign * ds / duration, dds / duration**2)]
    return Reference(t, *columns)


def test_the_prior_is_not_the_truth(script, truth) -> None:
    study = script("study")
    one, other = (study.with_prior(truth, 0.3, seed) for seed in (1, 2))
    off = fitted_values(one) / fitted_values(truth) - 1
    assert np.all(np.abs(off) <= 0.3) and np.all(np.abs(off) > 1e-6)
    assert not np.allclose(fitted_values(one), fitted_values(other))
    assert np.array_equal(fitted_values(one), fitted_values(study.with_prior(truth, 0.3, 1)))


def test_a_motion_keeps_to_its_share_of_the_limits(script, truth) -> None:
    study = script("study")
    rests = study.find_motion(
        truth, {"information": 1.25, "share": 0.5, "starts": 1, "rate": 50}, duration=3.0, moves=4, seed=0
    )
    table = study.sampled(truth, *rests, rate=50)
    assert len(table) == 151 and table["t"].iloc[-1] == 3.0
    for joint, velocity, acceleration in ((1, 4, 12), (2, 8, 40)):
        # between samples a little more; limits themselves are tested where they are made
        assert table[f"dq{joint}"].abs().max() <= 0.5 * velocity * 1.001
        assert table[f"ddq{joint}"].abs().max() <= 0.5 * acceleration * 1.001


def kept_motions() -> dict:
    return yaml.safe_load((ROOT / "data" / "motions.yaml").read_text(encoding="utf-8"))


def test_every_motion_is_kept_beside_its_settings(script, settings, truth) -> None:
    """Another processor's rounding ends in another motion, of which no committed number would be true."""
    own, model = settings["scara"], script("motion").depends_on(truth)
    assert model["limits"]["velocity"] == [4, 8]
    wanted = {name: own["motion"] | special | model for name, special in own["motions"].items()}
    assert {name: kept["settings"] for name, kept in kept_motions().items()} == wanted


@pytest.mark.parametrize("name", ["identify", "eq23"])
def test_a_kept_motion_is_as_good_as_one_found_now(script, settings, truth, name) -> None:
    """2 starts of the 8; five kinds of processor differed by 1 % in the mean singular value, 7 % in eq. 23."""
    study, own, kept = script("study"), settings["scara"], kept_motions()[name]
    found = study.find_motion(truth, own["motion"] | {"starts": 2}, **own["motions"][name])
    mean, value = zip(
        *(
            excitation(study.reference(study.sampled(truth, *rests, own["motion"]["rate"]), 2), truth)
            for rests in ((np.array(kept["points"]), np.array(kept["durations"])), found)
        ),
        strict=True,
    )
    assert value[0] < 1.1 * value[1] if name == "eq23" else mean[0] > 0.95 * mean[1]


def excitation(motion: Reference, model) -> tuple[float, float]:
    """Geometric mean of the singular values of W, and cond(W) + 1/sigma_min(W)."""
    from chebid.dynamics import make_dynamics
    from chebid.effects import Motion

    W = make_dynamics(model).regressor(Motion(motion.t, motion.q, motion.dq, motion.ddq))
    singular = np.linalg.svd(W.reshape(-1, W.shape[2]), compute_uv=False)
    return float(np.exp(np.log(singular).mean())), float(singular[0] / singular[-1] + 1 / singular[-1])


def test_other_settings_are_searched_anew(script, settings, tmp_path: Path, monkeypatch, capsys) -> None:
    own = settings["scara"] | {"motion": settings["scara"]["motion"] | {"starts": 1}}
    own["motions"] = {"identify": {"duration": 2.0, "moves": 3, "seed": 0}}
    lengths = []
    for chosen in (settings["scara"] | {"model": str(ROOT / own["model"])}, own | {"model": str(ROOT / own["model"])}):
        out = tmp_path / "motion.csv"
        monkeypatch.setattr(sys, "argv", ["motion.py", json.dumps({"scara": chosen}), "identify", str(out)])
        script("motion").main()
        lengths.append((len(pd.read_csv(out)), "kept" in capsys.readouterr().out))
    assert lengths == [(815, True), (201, False)]


def test_rests_are_put_where_all_joints_stop(script) -> None:
    motion = move()
    longer = script("monte_carlo_cases").rests(motion, 0.5)
    assert len(longer.t) == len(motion.t) + 100  # at the turn and at the end
    assert np.abs(np.diff(longer.q, axis=0)).max() <= np.abs(np.diff(motion.q, axis=0)).max()
    assert np.sum(np.all(longer.dq == 0, axis=1)) >= 100


def test_summary_of_known_errors(script) -> None:
    values = [9.0, 11.0, 12.0, 8.0]
    table = pd.DataFrame(
        {"record": "r", "method": "m", "parameter": "p", "seed": range(4), "truth": 10.0, "value": values}
    ).assign(sd=0.6, sd_eq26=0.4)
    row = script("monte_carlo_page").summary(table, ["record", "method", "parameter"]).iloc[0]
    assert row.bias == pytest.approx(0.0)
    assert row.rmse == pytest.approx(100 * np.sqrt(2.5) / 10)
    assert row.coverage == 0.5  # within 1.96 x 0.6
    assert row.coverage_eq26 == 0.0
    assert row.seeds == 4


def test_every_case_is_explained(script) -> None:
    assert set(script("monte_carlo_page").ABOUT) == set(script("monte_carlo_cases").CASES)


def test_table_1_prints_the_paper_with_its_contradictions(script, tmp_path: Path, settings: dict, truth) -> None:
    """A short record, through the same scripts as the workflow."""
    from chebid.simulate import simulate, simulated_table

    table_1, study = script("table_1"), script("study")
    rests = study.find_motion(
        truth, settings["scara"]["motion"] | {"starts": 2, "information": 1.25}, duration=4.0, moves=6, seed=0
    )
    motion = study.sampled(truth, *rests, rate=100)
    record = simulate(truth, fitted_values(truth), study.reference(motion, 2), seed=0)
    path = tmp_path / "record.csv"
    simulated_table(record, reference=True).to_csv(path, index=False)
    frame = table_1.table(settings["scara"], path)
    assert len(frame) == 48 and frame.notna().all(axis=None)
    inertias = frame[frame.parameter.isin(["ZZR1", "ZZ2", "LMX2"])]
    assert (inertias.value / inertias.truth - 1).abs().max() < 0.05
    page, tex = table_1.markdown(frame), table_1.latex(frame)
    lines = [line for line in page.splitlines() if line.startswith("|")]
    assert {line.count("|") for line in lines} == {11}
    assert "| iv | published | 3.45 | 0.02 | 0.82 | 0.061 | 0.125 | 0.014 | 0.01 | 0.135 |" in lines
    assert "|  | published % sd | 0.5 | 25 | 5 | 0.4 | 5<sup>a</sup> | 0.4<sup>a</sup> | 30 | 7 |" in lines
    assert all(line.count("&") == 9 for line in tex.splitlines() if line.endswith(r"\\"))


def test_records_named_in_the_settings_exist(settings: dict) -> None:
    assert set(settings["monte_carlo"]["records"]) <= set(settings["scara"]["motions"])
    json.dumps(settings)
