"""The judge of the blind study: names, joints, rivals and variables as chebid writes them."""

from types import SimpleNamespace

import pytest

pytest.importorskip("mujoco", reason="the blind study simulates with mujoco: pip install 'chebid[blind]'")

from blind.effects import ALL
from blind.judge import _symbols, fits, judge


@pytest.mark.parametrize(
    "variable, symbols",
    [
        ("q", {"q"}),
        ("abs(tau)*sign(dq)", {"tau", "dq"}),
        ("q[q1]*dq", {"other_q", "dq"}),
        ("q[q2]", {"q"}),
        ("t*sign(dq)", {"t", "dq"}),
        ("distance since reversal", {"reversal"}),
        ("dq[q1]", {"other_dq"}),
    ],
)
def test_variables_are_read(variable: str, symbols: set[str]):
    assert _symbols(variable, "q2") == symbols


def test_the_joint_counts_where_it_can_be_told():
    assert fits(ALL["spring"](1), ("spring", "q2"))
    assert not fits(ALL["spring"](1), ("spring", "q1"))
    assert fits(ALL["torque_gain"](1), ("torque_gain", "q1"))
    assert fits(ALL["payload"](None), ("payload", ""))


def verdict(status: str, sure: bool, *named: tuple[str, str], rivals: tuple[tuple[str, str], ...] = ()) -> dict:
    effects, alternatives = ([{"effect": e, "joint": j} for e, j in found] for found in (named, rivals))
    return {"verdict": {"status": status, "sure": sure, "effects": effects, "alternatives": alternatives}}


def test_right_wrong_and_among():
    case = SimpleNamespace(category="one", effects=[ALL["spring"](0)])
    right = judge(case, verdict("missing", True, ("spring", "q1")), {"added": [{"effect": "spring", "joint": "q1"}]})
    assert (right["first_right"], right["among"], right["sure_right"], right["exact"]) == (1, 1, 1, 1)
    rival = judge(case, verdict("missing", False, ("base_tilt", ""), rivals=(("spring", "q1"),)), None)
    assert (rival["first_right"], rival["among"], rival["sure_right"], rival["exact"]) == (0, 1, "", 0)
    wrong = judge(case, verdict("missing", True, ("spring", "q2")), None)
    assert (wrong["first_right"], wrong["among"], wrong["sure_right"]) == (0, 0, 0)
    silent = judge(case, None, None)
    assert (silent["status"], silent["first_right"], silent["sure_right"]) == ("no answer", 0, "")


def test_an_effect_called_sure_on_a_clean_log_is_wrong():
    case = SimpleNamespace(category="clean", effects=[])
    out = judge(case, verdict("missing", True, ("stribeck", "q1")), {"added": []})
    assert (out["sure_right"], out["found"], out["exact"]) == (0, 0, 1)  # nothing was added, which is exact
