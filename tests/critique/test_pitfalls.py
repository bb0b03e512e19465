"""No effect is called sure because of preprocessing: each row of "What goes wrong" in the notes on effects."""

import numpy as np
import pytest
from arms import make_log, make_model
from critique.hidden import COUNT, diagnosed, hidden_log, moves, named, on, sines, trapezoids
from scipy.integrate import cumulative_trapezoid

from chebid.critique import Found, message
from chebid.critique.calm import withstood
from chebid.critique.candidates import Candidate
from chebid.critique.verdict import believed
from chebid.effects import LIBRARY


def assert_not_fooled(d) -> None:
    assert not (d.verdict.status == "missing" and d.verdict.sure), message(d)


@pytest.mark.parametrize("degree", [40, 60, 90])
def test_a_degree_too_low_is_not_called_flexibility(degree):
    assert_not_fooled(diagnosed(hidden_log(moves(3), seed=1), processing={"degree": degree}))


def test_without_a_gate():
    assert_not_fooled(diagnosed(hidden_log(sines(3), seed=1), processing={"velocity_gate": 1e-6}))


def test_with_the_ends_of_the_record():
    assert_not_fooled(diagnosed(hidden_log(moves(3), seed=1), processing={"trim": 0.0}))


def test_encoder_spikes(tmp_path):
    from arms import write_log

    from chebid.log import LogSpec, read_log

    log = hidden_log(sines(3), seed=1)
    record = log.records[0]
    q = record.q.copy()
    q[[300, 777, 1402], [0, 1, 1]] += 0.05
    read = read_log(write_log(tmp_path / "log.csv", record.t, q, record.tau), LogSpec(), ("q1", "q2"))
    assert any(notice.kind == "spike" for notice in read.notices)
    assert_not_fooled(diagnosed(read))


@pytest.mark.parametrize("colour", [0.5, 0.9])
def test_coloured_noise(colour):
    assert_not_fooled(diagnosed(hidden_log(sines(8), seed=2, colour=colour)))


def test_accelerations_that_jump():
    """A motion of parabolas: its accelerations are steps, which no projection passes."""
    fine = np.arange(200_001) / 10_000
    steps = np.sign(np.sin(2 * np.pi * 0.45 * fine + 0.3)), np.sign(np.sin(2 * np.pi * 0.6 * fine + 1.0))
    ddq = np.column_stack(steps) * (2.0, 4.0)
    dq = cumulative_trapezoid(ddq, fine, axis=0, initial=0)
    dq -= dq.mean(axis=0)
    q = cumulative_trapezoid(dq, fine, axis=0, initial=0)
    t, q, dq, ddq = fine[::100], q[::100] - q.mean(axis=0), dq[::100], ddq[::100]
    from arms import Path3

    assert_not_fooled(diagnosed(hidden_log(Path3(t, q, dq, ddq), seed=1)))


@pytest.mark.parametrize("seed", [2, 3])
def test_constant_acceleration_is_no_dependence_on_it(seed):
    """Found by a probe: what an acceleration varies with on a ramp is noise, and the error is that same noise."""
    d = diagnosed(hidden_log(trapezoids(seed), seed=seed))
    assert_not_fooled(d)
    assert d.depends == ()


@pytest.mark.parametrize("late", [1e-3, -1e-3])
def test_torque_logged_half_a_control_period_off_is_no_effect(late):
    path = sines(3)
    log = hidden_log(path, seed=1)
    record = log.records[0]
    tau = np.column_stack([np.interp(path.t - late, path.t, column) for column in record.tau.T])
    found = diagnosed(make_log(record.t, record.q, tau))
    assert found.verdict.status == "nothing_missing"
    (told,) = (str(notice) for notice in found.notices if notice.kind == "torque_lag")
    assert ("lags" if late > 0 else "leads") in told
    assert "the lag told under DATA" in message(found)


def test_a_log_without_a_lag_is_told_none():
    assert not any(notice.kind == "torque_lag" for notice in diagnosed(hidden_log(sines(3), seed=1)).notices)


def test_torque_logged_long_after_is_one():
    late = 0.012
    path = sines(3)
    from arms import planar_torque

    noise = np.random.default_rng(1).standard_normal(path.q.shape) * (0.1, 0.02)
    tau = np.column_stack([np.interp(path.t - late, path.t, column) for column in planar_torque(path).T]) + noise
    d = diagnosed(make_log(path.t, np.round(path.q / COUNT) * COUNT, tau))
    assert named(d)[:1] == [("torque_delay", None)]
    assert d.verdict.best.parameters[0].value == pytest.approx(late, rel=0.15)  # to first order in the delay


def test_two_records_with_a_seam(tmp_path):
    """A glued log is cut where the time goes back, and says nothing it should not."""
    from arms import write_log

    from chebid.log import LogSpec, read_log

    parts = [hidden_log(moves(seed, 10.0), seed=seed).records[0] for seed in (1, 2)]
    t, q, tau = (np.concatenate([getattr(part, name) for part in parts]) for name in ("t", "q", "tau"))
    read = read_log(write_log(tmp_path / "log.csv", t, q, tau), LogSpec(), ("q1", "q2"))
    assert len(read.records) == 2
    assert diagnosed(read).verdict.status == "nothing_missing"


def test_an_effect_on_the_wrong_joint_is_not_blamed():
    """A hidden torque on joint 1 leaves joint 2 alone."""
    d = diagnosed(hidden_log(sines(9), on(0, lambda p: 0.4 * np.sin(11 * p.q[:, 0])), seed=9))
    assert {one.effect.joint for one in d.found if one.score > 12} <= {0, None}


@pytest.mark.parametrize("step", [1e-3, 4e-3])
@pytest.mark.parametrize("seed", [1, 3])
def test_a_coarse_encoder_makes_nothing_sure(seed, step):
    log = hidden_log(sines(4 + seed), seed=seed)
    record = log.records[0]
    verdict = diagnosed(make_log(record.t, np.round(record.q / step) * step, record.tau)).verdict
    assert verdict.status == "nothing_missing" or not verdict.sure


@pytest.mark.parametrize(("steps", "refuted"), [(0.5, True), (20.0, False)])
def test_no_bristle_within_the_steps_of_an_encoder(steps, refuted):
    """Found by the blind study: presliding over half a step of the encoder, called sure."""
    evidence = diagnosed(hidden_log(sines(4), seed=1)).evidence
    effect = LIBRARY["presliding"](0, delta=steps * COUNT)
    strong = Found(Candidate(evidence.judge(effect), 1, 500.0), 500.0, 100.0, 1.0, share=0.3)
    assert believed(strong)
    assert withstood(strong, evidence, evidence, 0.0).refuted is refuted


def test_the_step_of_an_encoder_is_found():
    from chebid.critique.evidence import Ground
    from chebid.estimators import Problem

    log = hidden_log(sines(4), seed=1)
    assert Ground(Problem(make_model(), (log,))).counts == pytest.approx([COUNT, COUNT])
