"""The ladder: two hidden effects found and no third, the file that records it, and what `add` and `refine` print."""

import json

import numpy as np
import pytest
import yaml
from arms import SCARA, make_log, make_model, write_log
from command import chebid
from critique.hidden import KINDS, hidden_log, moves, on, sines

from chebid.critique import addable_kinds, refine, settle_hyper
from chebid.effects import LIBRARY
from chebid.errors import UsageError
from chebid.estimators import Problem
from chebid.model import Model, read_model


def both(path) -> np.ndarray:
    spring = on(1, lambda p: 0.1 * (p.q[:, 1] - 0.3))
    coupling = on(0, lambda p: 0.3 * p.dq[:, 1])
    return spring(path) + coupling(path)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Logs with two hidden effects, a hold-out of another motion, the log of another day, and a fitted model."""
    made = tmp_path_factory.mktemp("refine")
    heavier = on(1, lambda p: 0.05 * np.sign(p.dq[:, 1]))
    for name, path, extra in (
        ("log", sines(5), both),
        ("other", moves(6), both),
        ("plain", sines(7), None),
        ("later", sines(8), heavier),
    ):
        record = hidden_log(path, extra, seed=len(name)).records[0]
        write_log(made / f"{name}.csv", record.t, record.q, record.tau)
    (made / "model.yaml").write_text(yaml.safe_dump(SCARA))
    for name in ("log", "plain"):
        answer = chebid("identify", made / f"{name}.csv", "-m", made / "model.yaml", "-o", made / f"{name}.yaml")
        assert answer.status == 0, answer.err
    return made


def test_both_effects_and_no_third(folder):
    model = Model.model_validate(SCARA)
    found = refine(Problem(model, (hidden_log(sines(5), both, seed=3),)), KINDS)
    assert {(one.effect.name, one.effect.joint) for one in found.added} == {("spring", 1), ("viscous_coupling", 0)}
    assert found.last.diagnosis.verdict.status == "nothing_missing"
    ratios = [[r.ratio for r in step.estimate.residual.values()] for step in found.steps]
    assert max(ratios[-1]) < 1.3 < max(ratios[0])


def test_refine_writes_a_model_that_explains_the_hold_out(folder):
    out = folder / "refined.yaml"
    answer = chebid(
        "refine", folder / "log.yaml", folder / "log.csv", "--holdout", folder / "other.csv", "-o", out, "--json"
    )
    assert answer.status == 0, answer.err
    document = answer.document
    assert document["steps"][0]["effect"] is None
    assert {(one["effect"], one["joint"]) for one in document["added"]} == {
        ("spring", "q2"),
        ("viscous_coupling", "q1"),
    }
    first, last = document["steps"][0], document["steps"][-1]
    assert max(last["holdout_ratio"].values()) < 1.5 < max(first["holdout_ratio"].values())
    made = read_model(out)
    assert made.fit is not None
    record = made.fit.record.model_dump()["refinement"]
    assert len(record["steps"]) == len(document["steps"])
    assert all(step["rejected"] is not None for step in record["steps"])
    compared = chebid("compare", out, folder / "other.csv", "--json").document
    assert max(row["ratio"] for row in compared["results"]) < 1.5


def test_the_document_of_diagnose_is_that_of_the_agreement(folder):
    document = chebid("diagnose", folder / "log.yaml", folder / "log.csv", "--json").document
    assert set(document) >= {"joints", "where", "depends_on", "candidates", "verdict", "data"}
    assert set(document["joints"][0]) >= {"joint", "rms", "floor", "ratio", "holdout_ratio", "explainable"}
    best = document["candidates"][0]
    assert set(best) >= {
        "effect", "joint", "score", "parameters", "hyperparameters", "ratio_after", "holdout_ratio_after", "stability",
    }  # fmt: skip
    assert set(document["verdict"]) >= {"status", "sure", "effects", "alternatives", "message"}
    assert document["verdict"]["status"] == "missing"
    json.dumps(document, allow_nan=False)


def test_on_another_day_it_is_told_what_has_changed(folder):
    """More Coulomb friction than at the fit: with free parameters there would be nothing to see."""
    document = chebid("diagnose", folder / "plain.yaml", folder / "later.csv", "--json").document
    verdict = document["verdict"]
    named = [*verdict["effects"], *verdict["alternatives"]]
    assert {"effect": "coulomb", "joint": "q2"} in named
    assert verdict["changed"]
    assert "changed since" in verdict["message"]


def test_add_tells_the_error_before_and_after(folder):
    out = folder / "added.yaml"
    answer = chebid("add", folder / "log.yaml", "spring:q2", folder / "log.csv", "-o", out, "--json", "--force")
    document = answer.document
    assert document["residual"]["q2"]["ratio"] < 0.8 * document["before"]["q2"]["ratio"]
    k = next(p for p in document["parameters"] if p["name"].startswith("k") and p["joint"] == "q2")
    assert k["value"] == pytest.approx(0.1, abs=4 * k["sd"])
    assert read_model(out).fit is not None


def test_the_last_line_is_the_command_to_type(folder):
    answer = chebid("diagnose", folder / "log.yaml", folder / "log.csv")
    sections = ("DATA", "FILTER", "COMPARE", "WHERE", "DEPENDS", "CANDIDATES", "VERDICT")
    places = [
        answer.out.index(f"{section} ") if section != "WHERE" else answer.out.index(section) for section in sections[:1]
    ]
    assert places == sorted(places)
    order = [
        answer.out.index("\n" + section) if section != "DATA" else answer.out.index(section) for section in sections
    ]
    assert order == sorted(order)
    assert answer.out.strip().splitlines()[-1].split()[1:3] == ["chebid", "add"]


@pytest.mark.parametrize(
    ("words", "status", "match"),
    [
        (("add", "log.yaml", "friction:q2", "log.csv"), 2, "unknown effect 'friction'"),
        (("add", "log.yaml", "spring:q9", "log.csv"), 2, "no joint 'q9'"),
        (("add", "log.yaml", "coulomb:q2", "log.csv"), 2, "already"),
        (("add", "log.yaml", "base_tilt:q1", "log.csv"), 2, "whole arm"),
        (("add", "log.yaml", "log.csv"), 2, "no effect"),
        (("add", "log.yaml", "spring:q2"), 2, "no log"),
        (("diagnose", "log.yaml", "log.csv", "--holdout", "log.csv"), 2, "cannot be held out"),
        (("diagnose", "log.yaml", "plain.csv", "--holdout", "log.csv"), 2, "cannot be held out"),
        (("diagnose", "log.yaml", "none.csv"), 3, "none.csv"),
    ],
)
def test_wrong_words_are_refused(folder, monkeypatch, words, status, match):
    monkeypatch.chdir(folder)
    answer = chebid(*words)
    assert answer.status == status, answer.err
    assert match in answer.error
    assert answer.hint


def test_an_effect_that_is_added_takes_the_form_that_was_named():
    """Found in review: `diagnose` named a spring that softens, and `add` put in a linear one."""
    from critique.hidden import hidden_log, on, sines

    from chebid.estimators import Problem

    soft = hidden_log(sines(5), on(0, lambda p: 0.8 * np.tanh((p.q[:, 0] - 0.2) / 2.5)), seed=3)
    linear = hidden_log(sines(5), on(0, lambda p: 0.3 * (p.q[:, 0] - 0.2)), seed=3)
    for log, named in ((soft, True), (linear, False)):
        (spec,) = settle_hyper(Problem(make_model(), (log,)), [(LIBRARY["spring"], 0)])
        assert ("r" in spec.model_dump(exclude_none=True)) is named


@pytest.mark.parametrize("name", sorted(addable_kinds()[0]))
def test_every_effect_can_be_added_by_name(name):
    """Found by hand: `add joint_flexibility` and `add backlash` broke down, `add motor_coupling` was unknown."""
    kind = addable_kinds()[0][name]
    log, model = hidden_log(sines(5), seed=3), make_model(effects=[])
    (spec,) = settle_hyper(Problem(model, (log,)), [(kind, None if kind.whole_arm else 1)])
    assert spec.effect == name
    assert (spec.joint is None) == kind.whole_arm
    assert set(spec.settings) >= set(kind.hypers()) - set(kind.defaults())


@pytest.mark.parametrize("hidden, kept", [(lambda p: 0.3 * p.dq[:, 1], True), (lambda p: 0 * p.dq[:, 1], False)])
def test_an_effect_is_not_exchanged_where_the_error_grows(monkeypatch, hidden, kept):
    """Found on a blind log: a simulated spring took the place of an effect, and tripled the error."""
    from chebid.critique.refine import _Ladder

    kinds = {"viscous_coupling": LIBRARY["viscous_coupling"], "offset": LIBRARY["offset"]}
    log = hidden_log(sines(5), on(0, hidden), seed=3)
    ladder = _Ladder(Problem(make_model(), (log,)), None, kinds, "poly", 0)
    first, new = LIBRARY["viscous_coupling"](0, source=1), LIBRARY["offset"](1)
    for instead in (None, LIBRARY["viscous_coupling"](1, source=0)):  # nothing; the same on another joint
        best = lambda self, evidence, effect, stays, instead=instead: effect if stays else instead  # noqa: E731
        monkeypatch.setattr(_Ladder, "_best", best)
        effects, dropped = ladder.revise([first], new)
        assert effects[-1] is new, "what the verdict called for stays"
        assert (first in effects, dropped) == ((True, []) if kept else (False, [first]))


def test_what_has_nothing_to_act_on_is_said():
    """Found in review: a coupling on an arm of one joint ended in a traceback."""
    (whole,) = hidden_log(sines(5), seed=3).records
    one = make_log(whole.t, whole.q[:, :1], whole.tau[:, :1], ["q1"])
    model = make_model({"robot": {"type": "axes", "types": ["revolute"]}, "joints": ["q1"], "effects": ["viscous"]})
    for name in ("viscous_coupling", "motor_coupling"):
        with pytest.raises(UsageError, match=f"{name} of q1 has nothing to act on"):
            settle_hyper(Problem(model, (one,)), [(LIBRARY[name], 0)])


def test_a_motor_of_two_joints_wants_one_of_them_named(folder):
    answer = chebid("add", folder / "log.yaml", "motor_coupling", folder / "log.csv", "-o", folder / "no.yaml")
    assert answer.status == 2
    assert "motor_coupling:" in answer.hint
