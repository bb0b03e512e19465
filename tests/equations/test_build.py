"""Projected rows: a dense twin, the gate and the trim, records, delay, and what must be refused."""

from dataclasses import replace

import naive
import numpy as np
import pytest
from arms import (
    JOINTS,
    THETA,
    TORQUE_NOISE,
    join_records,
    make_log,
    make_model,
    multisine,
    paper_moves,
    planar_torque,
    white,
)

from chebid.dynamics import make_dynamics
from chebid.equations import build, measured_rows, moving, project_columns
from chebid.errors import InputError, NoAnswerError
from chebid.estimators import Problem, estimate
from chebid.motion import make_track
from chebid.projection import Setting

DYNAMICS = make_dynamics(make_model())
GATE = np.array([0.05, 0.05])


def track_of(path, tau=None, setting=None, **options):
    log = make_log(path.t, path.q, planar_torque(path) if tau is None else tau)
    return make_track(log, log.records[0], setting or Setting(), **options)


def problem(path, tau=None, model=None, noise=0.0, **processing):
    """A problem on one record; `noise` a number of seeds of the torque noise, 0 for none."""
    tau = planar_torque(path) if tau is None else tau
    return Problem(model or make_model(processing=processing), (make_log(path.t, path.q, tau),))


def error(problem):
    """Relative errors (P,) of poly."""
    return estimate(problem, "poly").theta / THETA - 1


# --- against the twin ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "setting", "band"),
    [
        (paper_moves(), Setting(), 5.0),
        (multisine(1, 12.0), Setting(), 3.0),
        (multisine(2, 12.0, rate=250.0), Setting(), 20.0),  # several stretches
        (paper_moves(1, moves=12), Setting(degree=60), 1.0),  # a degree too low
    ],
    ids=["moves", "sines", "stretches", "low degree"],
)
def test_rows_are_those_of_the_dense_twin(path, setting, band):
    track = track_of(path, setting=setting)
    rows = measured_rows([track], DYNAMICS, GATE, band)
    slow = naive.projected_rows(track, DYNAMICS, GATE, band)
    assert track.whole == (setting.degree is None)
    for joint, expected in enumerate(slow):
        mine = np.column_stack([rows.W, rows.Y])[rows.joint == joint]
        assert mine.shape == expected.shape
        assert rows.noise[joint].equations == len(expected)
        # rows agree up to a rotation within each stretch, which leaves all inner products alone
        scale = np.abs(expected.T @ expected).max()
        np.testing.assert_allclose(mine.T @ mine, expected.T @ expected, atol=1e-9 * scale)


def test_gram_holds_the_energy_of_the_moving_samples():
    track = track_of(paper_moves())
    rows = measured_rows([track], DYNAMICS, GATE, 5.0)
    system, used = naive.system(track, DYNAMICS), moving(track, GATE)
    for joint, noise in enumerate(rows.noise):
        slow = system[used[:, joint], joint]
        assert noise.samples == used[:, joint].sum()
        expected = slow.T @ slow
        np.testing.assert_allclose(noise.gram, expected, atol=1e-12 * np.abs(expected).max())
        residual = slow[:, -1] - slow[:, :-1] @ THETA
        assert noise.energy(THETA) == pytest.approx(residual @ residual, rel=1e-4)  # differences of large sums


def test_chunks_change_nothing(monkeypatch):
    track = track_of(multisine(2, 12.0, rate=250.0))
    whole = measured_rows([track], DYNAMICS, GATE, 20.0)
    monkeypatch.setattr(build, "_CHUNK", 100)
    pieces = measured_rows([track], DYNAMICS, GATE, 20.0)
    np.testing.assert_allclose(pieces.W, whole.W, rtol=1e-12, atol=1e-12 * np.abs(whole.W).max())


def test_further_columns_come_as_the_rows_do():
    track = track_of(paper_moves())
    rows = measured_rows([track], DYNAMICS, GATE, 5.0)
    columns = project_columns(track, GATE, 5.0, DYNAMICS.regressor(track.motion))
    np.testing.assert_allclose(columns, rows.W, rtol=1e-12, atol=1e-12 * np.abs(rows.W).max())


# --- gate and trim ------------------------------------------------------------------------------------------------


def test_what_is_slow_or_trimmed_or_missing_is_not_looked_at():
    path = paper_moves()
    tau = planar_torque(path)
    base = measured_rows([track_of(path, tau, trim=0.5)], DYNAMICS, GATE, 5.0)
    spoiled = tau.copy()
    spoiled[np.abs(path.dq) < 0.045] = 1e3  # a little below the gate: the projected velocity is not quite the true one
    spoiled[:50], spoiled[-50:] = -1e3, 1e3
    rows = measured_rows([track_of(path, spoiled, trim=0.5)], DYNAMICS, GATE, 5.0)
    np.testing.assert_array_equal(rows.Y, base.Y)
    spoiled[200:205] = np.nan
    rows = measured_rows([track_of(path, spoiled, trim=0.5)], DYNAMICS, GATE, 5.0)
    assert np.isfinite(rows.W).all() and np.isfinite(rows.Y).all()
    assert [n.samples for n in rows.noise] < [n.samples for n in base.noise]


def test_settings_of_the_model_file_rule():
    made = problem(paper_moves(), velocity_gate=[0.3, 0.4], trim=1.195, equation_bandwidth=3.0)
    (track,) = made.tracks
    used = moving(track, made.gate)
    assert np.all(np.abs(track.motion.dq[used[:, 0], 0]) >= 0.3)
    assert np.all(np.abs(track.motion.dq[used[:, 1], 1]) >= 0.4)
    inside = np.flatnonzero(track.valid)
    assert (inside[0], inside[-1]) == (120, len(track.valid) - 121)
    assert made.band.frequency == 3.0
    assert made.rows.frequency.max() == pytest.approx(3.0)


def test_automatic_gate_leaves_most_of_the_motion_and_none_of_the_rest():
    path = paper_moves()
    made = problem(path)
    (track,) = made.tracks
    share = moving(track, made.gate)[track.valid].mean(axis=0)
    assert np.all((share > 0.8) & (share < 0.99))
    assert np.all(made.gate < 0.05 * np.percentile(np.abs(path.dq), 95, axis=0))


def test_stiction_samples_that_would_bias_friction_are_gated():
    """Facts: rest and stiction samples kept, Fs1 -26 %. At rest the torque is anything below Fs."""
    path = paper_moves()
    tau, still = planar_torque(path), np.abs(path.dq) < 0.02
    tau[still] = 0.1
    assert np.abs(error(problem(path, tau)))[2] < 0.02
    kept = error(problem(path, tau, velocity_gate=0.0))
    assert np.abs(kept)[2] > 3 * np.abs(error(problem(path, tau)))[2]


# --- a degree too low ---------------------------------------------------------------------------------------------


def test_projected_equations_repair_a_degree_too_low():
    """Facts, section 4: counted over six motions, Fs1 from tens of percent to one or two, inertias from 1-3 % to 0.2 %.

    The twin takes the same positions and the same moving samples, without the projection of the equations.
    """
    repaired, plain = [], []
    for seed in range(6):
        path = paper_moves(seed, moves=44)  # 40 s, degree 200: band 1.6 Hz for moves of 0.9 s
        made = problem(path, degree=200)
        (track,) = made.tracks
        assert not track.whole
        repaired.append(error(made))
        system, used = naive.system(track, DYNAMICS), moving(track, made.gate)
        weighted = [system[used[:, j], j] / TORQUE_NOISE[j] for j in range(2)]
        both = np.concatenate(weighted)
        plain.append(np.linalg.lstsq(both[:, :-1], both[:, -1])[0] / THETA - 1)
    repaired, plain = (np.sqrt(np.mean(np.square(x), axis=0)) for x in (repaired, plain))
    zzr1, fs1, zz2 = 0, 2, 3
    assert plain[fs1] > 0.08 and plain[zzr1] > 0.01  # else the test shows nothing
    assert repaired[fs1] < 0.02
    assert repaired[zzr1] < 0.003
    assert repaired[zz2] < 0.015


def test_a_band_in_which_nothing_moves_long_enough_is_said_so():
    with pytest.raises(NoAnswerError, match="joint q1 moves in stretches too short for a band of") as caught:
        problem(multisine(0, 10.0), degree=30).rows  # noqa: B018 - made when asked for
    assert "bandwidth" in caught.value.hint


def test_a_slow_joint_does_not_narrow_the_band_of_a_fast_one():
    """Deviations beside a slow joint are those alone."""
    fast, slow = multisine(0, 20.0, joints=1, top=3.0), multisine(1, 20.0, joints=1, top=0.12)
    rng = np.random.default_rng(0)

    def deviations(q, ddq, dq, names):
        data = {"robot": {"type": "axes"}, "joints": names, "effects": ["viscous", "coulomb"]}
        tau = ddq + 0.5 * dq + 0.3 * np.sign(dq) + 0.1 * rng.standard_normal(q.shape)
        log = make_log(fast.t, q + 1e-5 * rng.standard_normal(q.shape), tau, names)
        return estimate(Problem(make_model(data), (log,)), "poly").sd[:3]

    alone = deviations(fast.q, fast.ddq, fast.dq, ["a"])
    both = [np.column_stack([getattr(fast, x), getattr(slow, x)]) for x in ("q", "ddq", "dq")]
    np.testing.assert_allclose(deviations(*both, ["a", "b"]), alone, rtol=0.4)  # another draw of the noise


# --- records, clocks, delay ---------------------------------------------------------------------------------------


def parts_of(path, *bounds):
    tau = planar_torque(path)
    return [(path.t[a:b], path.q[a:b], tau[a:b]) for a, b in bounds]


def test_records_are_never_joined():
    """Rows of two records are those of each alone: a jump between them goes unseen."""
    first, second = multisine(0, 8.0), multisine(1, 8.0)
    tau = planar_torque(first), planar_torque(second)
    log = join_records([(first.t, first.q, tau[0]), (first.t[-1] + second.t, second.q + 0.7, tau[1] + 5)], JOINTS)
    tracks = [make_track(log, record, Setting(bandwidth=5.0)) for record in log.records]
    both = measured_rows(tracks, DYNAMICS, GATE, 3.0)
    alone = [measured_rows([track], DYNAMICS, GATE, 3.0) for track in tracks]
    np.testing.assert_array_equal(both.Y, np.concatenate([rows.Y for rows in alone]))
    np.testing.assert_array_equal(both.W, np.concatenate([rows.W for rows in alone]))
    assert set(both.block[: len(alone[0].Y)]).isdisjoint(both.block[len(alone[0].Y) :])
    assert both.noise[1].equations == sum(rows.noise[1].equations for rows in alone)


def test_the_order_of_records_does_not_matter():
    paths = multisine(0, 8.0), multisine(1, 10.0)
    rng = np.random.default_rng(0)
    logs = [make_log(p.t, p.q, planar_torque(p) + white(rng, p.q.shape, TORQUE_NOISE)) for p in paths]
    settings = {"bandwidth": 5.0, "velocity_gate": 0.05, "equation_bandwidth": 4.0}
    there = estimate(Problem(make_model(processing=settings), tuple(logs)), "poly")
    back = estimate(Problem(make_model(processing=settings), tuple(reversed(logs))), "poly")
    np.testing.assert_allclose(there.theta, back.theta, rtol=1e-9)
    np.testing.assert_allclose(there.sd, back.sd, rtol=1e-6)


def test_uneven_stamps_are_used_as_they_are():
    path = multisine(0, 10.0)
    rng = np.random.default_rng(1)
    jitter = path.t + 0.003 * rng.uniform(-1, 1, len(path.t))
    base = multisine(0, 10.0)
    exact = multisine_at(base, jitter)
    assert np.abs(error(problem(exact))).max() < 2e-3
    mean_step = replace(exact, t=path.t)
    assert np.abs(error(problem(mean_step))).max() > 0.02  # the same samples on a mean step


def multisine_at(_, t):
    """The motion of `multisine(0, 10.0)` at other instants."""
    from arms import sines

    rng = np.random.default_rng(0)
    frequency = rng.uniform(0.1, 1.5, (8, 2))
    phase, size = rng.uniform(0, 2 * np.pi, (2, 8, 2))
    return sines(t, frequency, 0.5 * (0.5 + size / (2 * np.pi)) / (1 + frequency), phase)


def test_a_delay_of_the_torque_is_undone():
    path, delay = multisine(0, 20.0), 0.007
    late = planar_torque(multisine_shifted(path, delay))
    undone = error(problem(path, late, make_model(log={"torque_delay": delay})))
    assert np.abs(undone).max() < 1e-3
    ignored = error(problem(path, late))
    assert np.abs(ignored[1]) > 0.3  # Fv1: about -J w^2 delay


def multisine_shifted(path, delay):
    """`multisine(0, ...)` as it was `delay` s before."""
    return multisine_at(path, path.t - delay)


# --- what must be refused -----------------------------------------------------------------------------------------


def test_a_joint_that_never_moves_is_named():
    path = multisine(0, 10.0)
    rng = np.random.default_rng(0)
    q = path.q.copy()
    q[:, 1] = 0.3 + 1e-4 * rng.standard_normal(len(q))
    still = replace(path, q=q, dq=path.dq * [1, 0], ddq=path.ddq * [1, 0])
    tau = planar_torque(still) + white(rng, q.shape, TORQUE_NOISE)
    with pytest.raises(NoAnswerError, match="joint q2 does not move") as caught:
        estimate(problem(still, tau), "poly")
    assert "record a motion of this joint" in caught.value.hint


def test_a_gate_above_every_speed_is_named():
    with pytest.raises(NoAnswerError, match="joint q2 is slower than its gate of 99") as caught:
        estimate(problem(multisine(0, 10.0), velocity_gate=[0.01, 99.0]), "poly")
    assert "velocity_gate" in caught.value.hint


def test_rank_loss_names_the_parameters():
    """Both joints at constant speed: no inertia can be seen."""
    t = np.arange(1000) / 100
    q = np.column_stack([0.5 * t, 0.7 * t])
    model = make_model({"robot": {"type": "axes"}, "joints": ["q1", "q2"], "effects": ["viscous", "coulomb"]})
    rng = np.random.default_rng(0)
    log = make_log(t, q, 1.0 + 0.1 * rng.standard_normal(q.shape))
    with pytest.raises(NoAnswerError, match=r"lost rank: only combinations of Fv\d, Fs\d") as caught:
        estimate(Problem(model, (log,)), "poly")
    assert "record a motion that excites them" in caught.value.hint


def test_a_log_without_torque_is_refused():
    path = multisine(0, 10.0)
    with pytest.raises(InputError, match="has no torque columns"):
        Problem(make_model(), (make_log(path.t, path.q, None),))
