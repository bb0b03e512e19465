"""Encoders that hang for seconds: named where the rest of the log says so, and only there."""

import numpy as np
import pytest
from spoiled import N, clean

from chebid.log import read_log
from chebid.motion import make_track
from chebid.projection import Setting

RATE = 100.0


def frozen(tmp_path, columns, **options):
    """(column, first row, last row, value) of every stretch that is called frozen; and the log."""
    np.savez(tmp_path / "log.npz", **columns)
    log = read_log(tmp_path / "log.npz", joints=[name for name in columns if name.startswith("q")], **options)
    places = [notice.place for notice in log.notices if notice.kind == "frozen"]
    return [(p.column, p.row, p.row_end, p.value) for p in places], log


def moves(rest: float = 1.0):
    """Two joints that go from place to place in turns, torques of inertia and friction that rest when they rest."""
    t = np.arange(int(40 * RATE)) / RATE
    place, q, tau = np.zeros(2), np.zeros((len(t), 2)), np.zeros((len(t), 2))
    rng = np.random.default_rng(3)
    for number, begin in enumerate(np.arange(0.5, 38.5, 1.0 + rest)):
        j, u = number % 2, np.clip(t - begin, 0, 1)
        way = rng.uniform(0.5, 1.5) * rng.choice([-1, 1])
        q[:, j] += way * u**3 * (10 - u * (15 - 6 * u))
        tau[:, j] += way * 60 * u * (1 - u) * (1 - 2 * u) + np.where((u > 0) & (u < 1), 3 * np.sign(way), 0)
        place[j] += way
    q = np.round(q / 2e-4) * 2e-4
    tau += 0.05 * rng.standard_normal(tau.shape)
    return {"t": t, "q1": q[:, 0], "q2": q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}


@pytest.mark.parametrize("rest", [0.0, 1.0, 3.0])
def test_a_robot_at_rest_between_moves_has_no_frozen_encoder(tmp_path, rest):
    """One joint rests while the other moves, for up to 7 s, on exactly one value; its torque rests too."""
    assert frozen(tmp_path, moves(rest))[0] == []


@pytest.mark.parametrize("first", [180, 600, 1013, 2000, 3700])
@pytest.mark.parametrize("column", ["q1", "q2"])
def test_two_seconds_of_a_frozen_encoder_are_named(tmp_path, first, column):
    """Whatever the joint did meanwhile, as long as it moved: the column, the rows, the value."""
    columns = moves(0.0)
    whole = columns[column].copy()
    columns[column][first : first + 200] = whole[first]
    assert np.ptp(whole[first : first + 200]) > 0.1  # it moved
    found, log = frozen(tmp_path, columns)
    assert len(found) == 1
    name, row, row_end, value = found[0]
    assert (name, row_end, value) == (column, first + 200, whole[first])
    same = first - int(np.argmax(whole[first::-1] != whole[first])) + 1  # from here on it was at that value anyway
    assert row == same + 2
    assert len(log.records) == 1
    assert np.isnan(log.records[0].q[row - 1 : row_end, int(column[1]) - 1]).all()


def test_a_frozen_encoder_that_ends_where_it_was_is_told_by_its_torque(tmp_path):
    """A joint that swings and is back when the encoder wakes up leaves no step; the torque swung too."""
    t = np.arange(3000) / RATE
    q, tau = np.sin(2 * t), -4 * np.sin(2 * t) + 0.5 * np.sign(np.cos(2 * t))
    first = round(0.75 * np.pi * RATE)  # the turning point at -1, and the one a period later
    end = first + round(np.pi * RATE)
    q[first:end] = q[first]
    found, _ = frozen(tmp_path, {"t": t, "q1": q, "tau1": tau})
    assert found == [("q1", first + 2, end, q[first])]
    still = np.where((t > t[first]) & (t < t[end]), tau[first], tau)
    assert frozen(tmp_path, {"t": t, "q1": q, "tau1": still})[0] == []


def test_a_seam_after_a_rest_stays_a_seam(tmp_path):
    """Two logs of robots at rest, one behind the other: all joints leap, nothing hung."""
    columns = {name: values[:N].copy() for name, values in clean().items()}
    for name in ("q1", "q2"):
        columns[name][700:800] = columns[name][700]
        columns[name][800:] += 0.9
    for name in ("tau1", "tau2"):
        columns[name][700:800] = columns[name][700]
    log = frozen(tmp_path, columns)[1]
    assert len(log.records) == 2
    assert "seam" in {notice.kind for notice in log.notices}


def test_no_motion_is_made_up_where_positions_lack(tmp_path):
    """Two seconds without samples are no part of an identification, nor is what lies just beside them; a spike is."""
    columns = moves(0.0)
    columns["q1"][1000:1200] = np.nan
    columns["q2"][3800:] = np.nan
    columns["q1"][2500] = np.nan
    np.savez(tmp_path / "log.npz", **columns)
    log = read_log(tmp_path / "log.npz", joints=("q1", "q2"))
    track = make_track(log, log.records[0], Setting())
    assert not track.valid[990:1210].any()
    assert not track.valid[3790:].any()
    assert track.valid[2480:2520].all()
    assert track.valid.sum() > 3400
    off = np.abs(track.motion.q - np.column_stack([moves(0.0)["q1"], moves(0.0)["q2"]]))[track.valid]
    assert off.max() < 2e-3  # ten counts: nothing that is used was made up
