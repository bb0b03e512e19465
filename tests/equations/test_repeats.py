"""The noise floor from repeats: right for any colour of noise and any error of the model, silent without repeats."""

import numpy as np
import pytest
from arms import (
    THETA,
    TORQUE_NOISE,
    Path3,
    coloured,
    make_log,
    make_model,
    multisine,
    paper_moves,
    periodic,
    planar_torque,
    point_to_point,
    sines,
    white,
)

from chebid.dynamics import make_dynamics
from chebid.equations import measured_rows, repeat_floor
from chebid.equations.repeats import period
from chebid.motion import make_track
from chebid.projection import Setting

DYNAMICS = make_dynamics(make_model())
GATE, BAND = np.array([0.05, 0.05]), 5.0


def track_of(path, tau):
    log = make_log(path.t, path.q, tau)
    return make_track(log, log.records[0], Setting(bandwidth=8.0), trim=0.3)


def in_band(track, noise):
    """rms (J,) of the noise itself on the rows, in torque per sample."""
    rows = measured_rows([track_of_noise(track, noise)], DYNAMICS, GATE, BAND)
    energy = [np.sum(rows.Y[rows.joint == j] ** 2) / rows.noise[j].samples for j in range(2)]
    return np.sqrt(energy)


def track_of_noise(track, noise):
    from dataclasses import replace

    return replace(track, tau=noise)


def floors(path, noise, seeds=12, wrong=1.0):
    """Mean square floors and mean square noise (J,) over seeds; `wrong` a factor on the parameters of the model."""
    tau = planar_torque(path)
    found, true = [], []
    for seed in range(seeds):
        drawn = noise(np.random.default_rng(seed), tau.shape, TORQUE_NOISE)
        track = track_of(path, tau + drawn)
        found.append(repeat_floor([track], DYNAMICS, wrong * THETA, GATE, BAND))
        true.append(in_band(track, drawn))
    return np.sqrt(np.mean(np.square(found), axis=0)), np.sqrt(np.mean(np.square(true), axis=0))


@pytest.mark.parametrize("noise", [white, coloured])
@pytest.mark.parametrize("repeats", [2.0, 5.0])
def test_the_floor_is_that_of_the_noise(noise, repeats):
    found, true = floors(periodic(4.0, repeats), noise)
    np.testing.assert_allclose(found, true, rtol=0.1)  # some 500 differences: 3 %


def test_the_error_of_the_model_drops_out():
    """The same noise, parameters 30 % wrong: residuals twenty times the noise, the same floor."""
    path = periodic(4.0, 5.0)
    right, _ = floors(path, white, seeds=4)
    wrong, _ = floors(path, white, seeds=4, wrong=1.3)
    np.testing.assert_allclose(wrong, right, rtol=0.02)


def test_moves_to_and_fro_repeat():
    corners = [[0.0, 0.0], [1.0, -0.8], [-0.4, 0.9], [0.7, 0.3]] * 3 + [[0.0, 0.0]]
    found, true = floors(point_to_point(corners), white)
    np.testing.assert_allclose(found, true, rtol=0.1)


@pytest.mark.parametrize("length", [2.0, 4.0, 5.3])
def test_period_in_samples(length):
    path = periodic(length, 12 / length)
    assert period(track_of(path, planar_torque(path))) == round(length * 100)


@pytest.mark.parametrize(
    "path",
    [
        *(multisine(seed, 20.0) for seed in range(6)),
        *(paper_moves(seed, moves=20) for seed in range(6)),
        multisine(0, 20.0, top=0.25),  # slow: neighbouring samples are alike without any repeat
        multisine(0, 20.0, rate=1000.0, top=0.5),
        periodic(4.0, 1.3),  # less than half a period comes again
    ],
)
def test_nothing_repeats(path):
    track = track_of(path, planar_torque(path))
    assert period(track) is None
    assert repeat_floor([track], DYNAMICS, THETA, GATE, BAND) is None


def test_a_record_that_repeats_speaks_for_those_that_do_not():
    rng = np.random.default_rng(0)
    repeating, other = periodic(4.0, 5.0), multisine(3, 10.0)
    tracks = [track_of(p, planar_torque(p) + white(rng, p.q.shape, TORQUE_NOISE)) for p in (repeating, other)]
    alone = repeat_floor(tracks[:1], DYNAMICS, THETA, GATE, BAND)
    both = repeat_floor(tracks, DYNAMICS, THETA, GATE, BAND)
    np.testing.assert_allclose(both, alone, rtol=0.03)  # only the rows to a sample are those of both records


def test_a_jittering_drive_whose_torque_is_late_is_not_taken_for_noise():
    """Passes that differ in fast, small motions, as no drive repeats exactly, and a torque logged 5 ms late.

    The delay is an error of the model, but other than in what repeats it does not drop out by itself: it made the floor
    eight times too large on a positioning stage whose log lacked 0.8 ms.
    """
    base = periodic(4.0, 5.0)
    frequency = np.random.default_rng(5).uniform(3.0, 4.5, (4, 2))
    jitter = sines(base.t, frequency, np.full((4, 2), 8e-3), np.arange(8.0).reshape(4, 2))
    path = Path3(base.t, base.q + jitter.q, base.dq + jitter.dq, base.ddq + jitter.ddq)
    assert period(track_of(path, planar_torque(path))) == 400
    late = planar_torque(path) - 5e-3 * np.gradient(planar_torque(path), path.t, axis=0)
    squares, true = [], []
    for seed in range(6):
        noise = white(np.random.default_rng(seed), late.shape, 0.3 * TORQUE_NOISE)
        squares.append(repeat_floor([track_of(path, late + noise)], DYNAMICS, THETA, GATE, BAND) ** 2)
        true.append(in_band(track_of(path, late), noise) ** 2)
    ratio = np.sqrt(np.mean(squares, axis=0) / np.mean(true, axis=0))
    assert np.all(ratio < 1.3), ratio
