"""`read_log`: records, what the checks find, and what they must not find in clean logs."""

import hashlib

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from spoiled import JOINTS, RATE, N, cells, clean, joined, numbers, written

from chebid.errors import InputError, Notice
from chebid.log import LogSpec, read_log
from chebid.log.average import at_instants
from chebid.log.gains import apply_gain, gain_matrix
from chebid.log.record import is_uniform, stamp_resolution
from chebid.log.roughness import WHITE, local_noise, printed_resolution, quantum, roughness
from chebid.log.seams import find_jumps, unwrap
from chebid.log.spikes import distance, find_spikes


def read(tmp_path, columns, **options):
    options.setdefault("need_torque", True)
    return read_log(numbers(columns)(tmp_path), joints=JOINTS, name="log.csv", **options)


def kinds(log):
    return [notice.kind for notice in log.notices]


# --- reading --------------------------------------------------------------------------------------------------------


def test_a_clean_log_is_one_record_in_si_units(tmp_path):
    columns = clean()
    spec = LogSpec(position_gain=2.0, position_offset=(0.5, -0.5), torque_gain=(3.0, -4.0))
    log = read(tmp_path, columns, spec=spec)
    (record,) = log.records
    assert log.names == JOINTS
    assert log.notices == ()
    assert log.sha256 == hashlib.sha256((tmp_path / "log.csv").read_bytes()).hexdigest()
    assert record.uniform
    assert record.rate == pytest.approx(RATE, rel=1e-9)
    assert record.duration == pytest.approx((N - 1) / RATE, rel=1e-12)
    assert record.rows.tolist() == list(range(2, N + 2))
    printed = {name: np.array([float(f"{value:.10g}") for value in column]) for name, column in columns.items()}
    np.testing.assert_array_equal(record.t, printed["t"])
    np.testing.assert_array_equal(record.q, 2 * np.stack([printed["q1"], printed["q2"]], 1) + [0.5, -0.5])
    np.testing.assert_array_equal(record.tau, np.stack([3 * printed["tau1"], -4 * printed["tau2"]], 1))
    assert record.reference is None


@pytest.mark.parametrize("suffix", [".npz", ".mat", ".parquet", ".h5"])
def test_every_format_gives_the_same_record(tmp_path, suffix):
    expected = clean()
    (record,) = read_log(written(expected, suffix)(tmp_path), joints=JOINTS).records
    np.testing.assert_array_equal(record.t, expected["t"])
    np.testing.assert_array_equal(record.q, np.stack([expected["q1"], expected["q2"]], 1))
    np.testing.assert_array_equal(record.tau, np.stack([expected["tau1"], expected["tau2"]], 1))
    assert record.rows[0] == 1


def test_names_of_joints_serve_as_columns(tmp_path):
    columns = clean()
    named = {"time": columns["t"], "hip": columns["q1"], "knee": columns["q2"]}
    named |= {"tau_hip": columns["tau1"], "tau_knee": columns["tau2"]}
    log = read_log(numbers(named)(tmp_path), joints=("hip", "knee"), need_torque=True)
    assert log.records[0].tau is not None


def test_reference_is_read_when_it_is_named(tmp_path):
    columns = {**clean(), "r1": clean()["q1"], "r2": clean()["q2"]}
    spec = LogSpec(reference=("r1", "r2"), position_gain=2.0, position_offset=1.0)
    (record,) = read(tmp_path, columns, spec=spec).records
    np.testing.assert_array_equal(record.reference, record.q)
    with pytest.raises(InputError, match="no column 'r3'"):
        read(tmp_path, columns, spec=LogSpec(reference=("r1", "r3")))


def test_means_of_a_torque_become_its_values(tmp_path):
    """The mean of a sine over L is sinc(f L) times the sine: what is left of the loss is (2 pi f L)^4 / 200."""
    columns, f, length = clean(), 3.0, 3 / RATE
    wave = np.sin(2 * np.pi * f * columns["t"] + 0.4)
    columns |= {"tau1": 5 * np.sinc(f * length) * wave, "tau2": columns["tau2"]}
    plain, (record,) = (
        read(tmp_path, columns).records[0],
        read(tmp_path, columns, spec=LogSpec(torque_average=length)).records,
    )
    x = 2 * np.pi * f * length
    inner = slice(3, -3)
    assert np.abs(plain.tau[inner, 0] - 5 * wave[inner]).max() > 0.9 * 5 * x**2 / 24
    np.testing.assert_allclose(record.tau[inner, 0], 5 * wave[inner], atol=5 * x**4 / 200)
    np.testing.assert_array_equal(record.tau[[0, 1, 2, -3, -2, -1]], plain.tau[[0, 1, 2, -3, -2, -1]])
    with pytest.raises(InputError, match=r"torque_average.*below zero"):
        read(tmp_path, columns, spec=LogSpec(torque_average=-0.01))


def test_means_beside_a_missing_torque_stay_as_they_are():
    t = np.arange(9.0)
    means = np.column_stack([t**2, t**2])
    means[4, 0] = np.nan
    tau = at_instants(t, means, 1.0)
    np.testing.assert_array_equal(tau[[0, 3, 4, 5, 8], 0], means[[0, 3, 4, 5, 8], 0])
    # of a parabola the mean is exactly 1/12 more
    np.testing.assert_allclose(tau[1:-1, 1], t[1:-1] ** 2 - 1 / 12, atol=1e-14)


def test_a_log_without_torque_is_refused_only_when_it_is_needed(tmp_path):
    columns = clean()
    del columns["tau2"]
    assert read(tmp_path, columns, need_torque=False).records[0].tau is None
    spec = LogSpec(torque=("tau1", "tau2"))
    assert read(tmp_path, columns, need_torque=False, spec=spec).records[0].tau is None
    with pytest.raises(InputError, match="no column 'tau2'"):
        read(tmp_path, columns)


def test_without_a_model_all_signals_are_read(tmp_path):
    path = numbers({**clean(), "empty": np.full(N, np.nan)})(tmp_path)
    log = read_log(path)
    assert log.names == ("q1", "q2", "tau1", "tau2")
    assert log.records[0].q.shape == (N, 4)
    assert log.records[0].tau is None
    assert kinds(log) == ["left_out"]
    assert read_log(path, signals=["tau2", "q1"]).names == ("tau2", "q1")
    with pytest.raises(InputError, match="no column 'q7'"):
        read_log(path, signals=["q7"])


def test_a_log_without_header_can_be_referred_to(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(joined(cells(clean())[1:]))
    spec = LogSpec(time="column 1", position=("column 2", "column 3"), torque=("column 4", "column 5"))
    np.testing.assert_allclose(read_log(path, spec, JOINTS).records[0].q[:, 0], clean()["q1"], rtol=1e-9)
    with pytest.raises(InputError) as caught:
        read_log(path, joints=JOINTS)
    assert "no header line" in caught.value.hint


def test_a_growing_column_is_offered_as_the_time(tmp_path):
    columns = clean()
    path = numbers({"stempel": columns.pop("t"), **columns})(tmp_path)
    with pytest.raises(InputError, match="no time column") as caught:
        read_log(path, joints=JOINTS)
    assert "stempel" in caught.value.hint


# --- gains ----------------------------------------------------------------------------------------------------------


def test_a_missing_sample_spoils_only_the_joints_it_enters():
    logged = np.arange(12.0).reshape(4, 3)
    gain = np.array([[1.0, 0, 0], [0, 2, 0], [0, -1, 3]])
    whole = apply_gain(logged, gain, (0.1, 0.2, 0.3))
    np.testing.assert_array_equal(whole, logged @ gain.T + [0.1, 0.2, 0.3])
    logged[2, 1] = np.nan
    spoiled = apply_gain(logged, gain, (0.1, 0.2, 0.3))
    assert np.isnan(spoiled).tolist() == [[False] * 3, [False] * 3, [False, True, True], [False] * 3]
    np.testing.assert_array_equal(spoiled[~np.isnan(spoiled)], whole[~np.isnan(spoiled)])


def test_a_gain_is_a_number_one_per_joint_or_a_matrix():
    np.testing.assert_array_equal(gain_matrix(2.0, 2, 2, "g"), 2 * np.eye(2))
    np.testing.assert_array_equal(gain_matrix((2.0, 3.0), 2, 2, "g"), np.diag([2.0, 3.0]))
    np.testing.assert_array_equal(gain_matrix(((1.0, 2.0, 3.0),), 1, 3, "g"), [[1.0, 2.0, 3.0]])
    for gain, joints, columns in (((1.0, 2.0), 3, 3), (1.0, 2, 3), (((1.0,),), 2, 1)):
        with pytest.raises(InputError, match=r"does not fit|names 3 columns for 2 joints"):
            gain_matrix(gain, joints, columns, "position_gain")


# --- time -----------------------------------------------------------------------------------------------------------


def test_stamps_are_never_replaced(tmp_path):
    columns = clean()
    columns["t"] = np.round(np.sort(columns["t"] + 5e-4 * np.random.default_rng(0).uniform(-1, 1, N)), 7)
    log = read(tmp_path, columns)
    np.testing.assert_array_equal(log.records[0].t, columns["t"])
    assert not log.records[0].uniform
    assert kinds(log) == ["uneven"]


def test_nothing_joins_two_records(tmp_path):
    columns = clean()
    columns["t"][500:] += 3.0
    columns["t"][1000:] -= 5.0
    log = read(tmp_path, columns)
    assert [len(record.t) for record in log.records] == [500, 500, 500]
    assert [record.rows[0] for record in log.records] == [2, 502, 1002]
    assert all((np.diff(record.t) > 0).all() for record in log.records)
    assert [(notice.kind, notice.place.row) for notice in log.notices] == [("gap", 502), ("time_back", 1002)]


def test_lost_samples_are_no_gap(tmp_path):
    columns = {name: np.delete(column, [400, 401, 900]) for name, column in clean().items()}
    log = read(tmp_path, columns)
    assert len(log.records) == 1
    assert [(notice.kind, notice.place.row) for notice in log.notices] == [("lost_samples", 402)]
    assert "3 samples were lost" in log.notices[0].message


def test_a_lost_sample_is_not_taken_for_a_rounded_clock(tmp_path):
    t = np.delete(np.arange(N + 1) / 1000, 700)  # stamps and steps of one millisecond
    log = read(tmp_path, {**clean(), "t": t})
    assert [(notice.kind, notice.place.row) for notice in log.notices] == [("lost_samples", 702)]
    rounded = np.round(np.arange(N) / 800, 3)  # steps of one and two milliseconds
    assert kinds(read(tmp_path, {**clean(), "t": rounded})) == ["time_rounded"]


def test_single_precision_and_printed_stamps_are_even():
    t = np.arange(20000) / 1000
    assert is_uniform(t)
    assert is_uniform(t.astype(np.float32).astype(float))
    assert is_uniform(np.round(t, 6))
    assert not is_uniform(np.round(np.arange(2000) / 300, 3))
    assert not is_uniform(np.delete(t, 700))
    assert stamp_resolution(np.round(np.arange(1, 2000) / 300, 3)) == 1e-3


def test_a_clock_in_milliseconds_is_read_when_its_name_or_the_rate_tells(tmp_path):
    columns = clean()
    renamed = {"t [ms]": 1000 * columns["t"], **{name: columns[name] for name in list(columns)[1:]}}
    log = read_log(numbers(renamed)(tmp_path), joints=JOINTS)
    assert kinds(log) == ["time_unit"]
    np.testing.assert_allclose(log.records[0].t, columns["t"], atol=1e-12)


# --- the detectors against what they promise -------------------------------------------------------------------------


def test_roughness_of_white_noise_is_what_it_says():
    x = np.random.default_rng(0).standard_normal(200_000)
    for t in (np.arange(len(x)) * 1e-3, np.cumsum(np.random.default_rng(1).uniform(0.5, 1.5, len(x)))):
        r = roughness(t, x)
        assert np.sqrt(np.mean(r**2)) == pytest.approx(WHITE, rel=0.02)  # 200 000 samples: some 0.3 %
        assert np.median(local_noise(r)) == pytest.approx(1.0, rel=0.02)


@given(st.lists(st.floats(-2, 2), min_size=4, max_size=4))
def test_a_cubic_has_no_roughness(coefficients):
    t = np.sort(np.random.default_rng(3).uniform(0, 1, 60)) + np.arange(60) * 1e-3
    x = np.polynomial.polynomial.polyval(t, coefficients)
    # Lagrange weights on uneven stamps reach 1e4, so that rounding errors grow by as much
    assert roughness(t, x).max() <= 1e-11 * max(1.0, np.abs(coefficients).sum())
    off, misfit = distance(t, x, np.arange(9, 50), 1)
    assert off.max() <= 1e-7 * max(1.0, np.abs(coefficients).sum())
    assert misfit.max() <= 1e-7 * max(1.0, np.abs(coefficients).sum())


def test_counting_is_recognised():
    rng = np.random.default_rng(0)
    x = np.cumsum(rng.standard_normal(5000)) * 1e-3
    assert quantum(np.round(x / 2e-4) * 2e-4) == pytest.approx(2e-4, rel=1e-6)
    assert quantum(x) == 0.0
    digits = np.array([float(f"{value:.4e}") for value in np.linspace(0.5, 150, 3000)])
    step = printed_resolution(digits)
    assert (step[digits < 1].max(), step[-1]) == (pytest.approx(1e-5), pytest.approx(1e-2))


def piecewise():
    """Motions with every kind of corner, sampled so that the corner falls anywhere between two samples."""
    for shift in np.linspace(0, 1, 11):
        u = np.arange(80.0) - 40 - shift
        yield "kink", np.abs(u)
        yield "step", (u > 0) * 30.0
        yield "stop", np.where(u < 0, u, 0.0)
        yield "bang", np.where(u > 0, u**2, 0.0)
        yield "jerk", np.where(u > 0, u**3, 0.0)
        for length in (3, 5, 8, 12):
            yield f"ramp of {length}", np.clip(u, 0, length)
            yield (
                f"there and back in {2 * length}",
                np.where(u < length, np.clip(u, 0, None), np.clip(2 * length - u, 0, None)),
            )


def test_no_corner_of_a_motion_is_a_spike():
    t = np.arange(80.0)
    for name, x in piecewise():
        assert not find_spikes(t, x, 6.0).any(), name


@pytest.mark.parametrize("length", [1, 2, 3])
def test_a_spike_on_a_corner_is_still_one(length):
    t = np.arange(80.0)
    for name, x in piecewise():
        spoiled = x + 1e-3 * np.random.default_rng(0).standard_normal(80)
        spoiled[15 : 15 + length] += 5.0
        found = np.flatnonzero(find_spikes(t, spoiled, 6.0)).tolist()
        assert found == list(range(15, 15 + length)), name


def test_turns_are_undone_exactly():
    angle = np.linspace(0, 40, 4000)
    for period in (2 * np.pi, 360.0):
        scaled = angle * period / (2 * np.pi)
        wrapped = (scaled + 0.3) % period
        values, found, turns = unwrap(wrapped, (2 * np.pi, 360.0))
        assert found == period
        assert len(turns) == 6
        # a subtraction of period after wrapping loses a unit in the last place of the period
        np.testing.assert_allclose(values, scaled + 0.3, atol=4e-13 * period)


def test_a_torque_that_changes_its_sign_is_no_turn():
    rng = np.random.default_rng(0)
    t = np.arange(3000) / 500
    torque = np.pi * np.sign(np.sin(9 * t)) + 0.3 * np.sin(2 * t) + 0.02 * rng.standard_normal(3000)
    assert len(unwrap(torque - 0.15 * np.sign(torque), (2 * np.pi,))[2]) == 0
    assert len(unwrap(rng.uniform(-3, 3, 3000), (2 * np.pi,))[2]) == 0


def test_a_jump_of_another_size_is_no_turn():
    x = np.sin(np.linspace(0, 10, 2000))
    x[1000:] -= 6.0
    assert len(unwrap(x, (2 * np.pi,))[2]) == 0
    assert find_jumps(np.arange(2000.0), x, 3.0).cuts == (1000,)


def test_a_short_fast_motion_is_no_jump():
    x = np.concatenate([np.zeros(9000), np.linspace(0, 1, 4), np.ones(9000)])
    assert find_jumps(np.arange(len(x)) * 1e-3, x, 3.0).cuts == ()


def test_what_is_left_out_is_missing_and_nothing_else(tmp_path):
    columns = clean()
    columns["q1"][700] += 0.3
    columns["tau2"][300] += 40.0
    (record,) = read(tmp_path, columns).records
    assert np.argwhere(np.isnan(record.q)).tolist() == [[700, 0]]
    assert np.argwhere(np.isnan(record.tau)).tolist() == [[300, 1]]


def test_a_wrapped_joint_is_continuous_afterwards(tmp_path):
    columns = clean()
    turning = 6 * columns["t"]
    columns["q1"] = (turning + np.pi) % (2 * np.pi) - np.pi
    log = read(tmp_path, columns)
    np.testing.assert_allclose(log.records[0].q[:, 0], turning, atol=1e-8)  # the file holds ten digits
    assert kinds(log) == ["wrapped"]
    assert log.notices[0].place.row == 2 + int(np.argmax(turning > np.pi))


def test_a_notice_names_the_logged_column_and_value(tmp_path):
    columns = clean()
    columns["q2"][100] = 2.5
    log = read(tmp_path, columns, spec=LogSpec(position_gain=((1.0, 0.0), (-0.7, 0.1))))
    (notice,) = log.notices
    assert isinstance(notice, Notice)
    assert (notice.kind, notice.place.file, notice.place.column) == ("spike", "log.csv", "q2")
    assert (notice.place.row, notice.place.value) == (102, 2.5)
    assert np.isnan(log.records[0].q[100]).tolist() == [False, True]


# --- measured logs ----------------------------------------------------------------------------------------------------

MEASURED = [
    ("emps", "DATA_EMPS.mat", 24841),
    ("emps", "DATA_EMPS_PULSES.mat", 24841),
    ("kr300", "traj_A.csv", 2501),
    ("kr300", "traj_B.csv", 2501),
    ("kr300", "traj_C.csv", 2501),
    ("tx40", "tx40.csv", 45000),
    ("ur10", "ur10_exciting_trajectory.csv", 3441),
]


def tuples(value):
    return tuple(tuples(one) for one in value) if isinstance(value, list) else value


@pytest.mark.parametrize(("robot", "name", "samples"), MEASURED, ids=[name for _, name, _ in MEASURED])
def test_nothing_is_found_in_measured_logs(shared_data, robot, name, samples):
    model = yaml.safe_load((shared_data / robot / "model.yaml").read_text())
    spec = LogSpec(**{key: tuples(value) for key, value in model["log"].items()})
    log = read_log(shared_data / robot / name, spec, model["joints"], need_torque=True)
    assert log.notices == ()
    (record,) = log.records
    assert record.q.shape == record.tau.shape == (samples, len(model["joints"]))
    assert record.uniform
    assert np.isfinite(record.q).all()
    assert np.isfinite(record.tau).all()


def test_a_column_of_infinities_is_no_clock():
    """Found by fuzzing: the difference of two infinities warns; comparing them does not."""
    from chebid.log.choice import _grows

    assert not _grows(np.array([np.inf, np.inf, np.inf]))
    assert _grows(np.array([0.0, 1.0, np.inf]))
