"""Warnings about models that cannot be: exchanged columns, a dead torque channel."""

import pandas as pd
import pytest

from chebid.errors import InputError
from chebid.estimators import Problem, estimate
from chebid.log import read_log
from chebid.model import read_model


def identify(project, path):
    model = read_model(project / "data/scara.yaml")
    return estimate(Problem(model, (read_log(path, model.log, model.joints, need_torque=True),)), "poly")


@pytest.fixture
def table(project):
    return pd.read_csv(project / "data/scara.csv")


@pytest.mark.parametrize(("first", "second"), [("q1", "q2"), ("tau1", "tau2")])
def test_exchanged_columns_are_doubted(project, table, tmp_path, first, second):
    table.rename(columns={first: second, second: first}).to_csv(tmp_path / "log.csv", index=False)
    kinds = {notice.kind for notice in identify(project, tmp_path / "log.csv").notices}
    assert kinds & {"implausible", "poor_fit"}


def test_a_negative_inertia_is_named(project, table, tmp_path):
    table.assign(tau1=-table.tau1, tau2=-table.tau2).to_csv(tmp_path / "log.csv", index=False)
    found = [n.message for n in identify(project, tmp_path / "log.csv").notices if n.kind == "implausible"]
    assert any(message.startswith("ZZR1 is -3.4") for message in found)


def test_a_right_log_is_not_doubted(project):
    kinds = {notice.kind for notice in identify(project, project / "data/scara.csv").notices}
    assert not kinds & {"implausible", "poor_fit"}


def test_a_dead_torque_channel_is_refused(project, table, tmp_path):
    table.assign(tau2=0.0).to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(InputError, match="torque of joint q2 never changes"):
        identify(project, tmp_path / "log.csv")
