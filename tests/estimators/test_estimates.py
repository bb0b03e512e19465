"""From a log to an estimate: unbiased, consistent, equivariant, and as honest as it claims to be."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from arms import (
    JOINTS,
    THETA,
    TORQUE_NOISE,
    Path3,
    coloured,
    make_log,
    make_model,
    multisine,
    paper_moves,
    planar_torque,
    white,
)

from chebid.equations import project_columns
from chebid.estimators import Problem, estimate
from chebid.estimators.weighted import solve

ENCODER = 5e-5  # rad of white noise on the positions: 16 bits a turn
AXES = {"robot": {"type": "axes"}, "joints": ["a", "b"], "effects": ["viscous", "coulomb"]}


def problem(path: Path3, seed: int, noise=white, model=None, torque=1.0, position=1.0, time=1.0) -> Problem:
    """A noisy log of the SCARA, in units of torque, position and time of one's own."""
    rng = np.random.default_rng(seed)
    q = path.q + white(rng, path.q.shape, ENCODER)
    tau = planar_torque(path) + noise(rng, path.q.shape, TORQUE_NOISE)
    return Problem(model or make_model(), (make_log(time * path.t, position * q, torque * tau),))


# --- bias and consistency -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("poly", paper_moves(moves=20)),
        ("poly", multisine(1, 20.0)),
        ("wls", paper_moves(moves=20)),
        ("wls", multisine(1, 20.0)),
    ],
    ids=["poly moves", "poly sines", "wls moves", "wls sines"],
)
def test_the_mean_of_many_estimates_is_the_truth(method, path):
    """Within four standard errors of the mean, or half a deviation: what the filters bend is less than the noise."""
    thetas, sds = [], []
    for seed in range(12):
        found = estimate(problem(path, seed), method)
        thetas.append(found.theta)
        sds.append(found.sd)
    bias = np.mean(thetas, axis=0) - THETA
    allowed = np.maximum(4 * np.std(thetas, axis=0) / np.sqrt(12), 0.5 * np.mean(sds, axis=0))
    np.testing.assert_array_less(np.abs(bias), allowed)


def test_a_record_four_times_as_long_halves_the_deviations():
    errors = {}
    for duration in (15.0, 60.0):
        found = [estimate(problem(multisine(0, duration), seed), "poly") for seed in range(3)]
        errors[duration] = np.mean([e.sd for e in found], axis=0)
        assert np.all(np.abs(np.mean([e.theta for e in found], axis=0) - THETA) < 4 * errors[duration])
    ratio = errors[15.0] / errors[60.0]
    assert 1.5 < np.median(ratio) < 3.0  # 2 but for the ends, which a short record has more of


def test_without_noise_the_truth():
    path = multisine(0, 20.0)
    log = make_log(path.t, path.q, planar_torque(path))
    np.testing.assert_allclose(estimate(Problem(make_model(), (log,)), "poly").theta, THETA, rtol=5e-3)
    np.testing.assert_allclose(estimate(Problem(make_model(), (log,)), "wls").theta, THETA, rtol=3e-2)


def test_per_joint_weights_help_the_quiet_joint():
    """Facts, section 2: without them the parameters of joint 2 come out some four times worse."""
    made = problem(paper_moves(), 0)
    draw = _redraw(made)
    weighted, plain = [], []
    for seed in range(60):
        rows = draw(seed, white)
        weighted.append(solve(rows, made.dynamics.parameters).theta)
        plain.append(np.linalg.lstsq(rows.W, rows.Y)[0])
    ratio = np.std(plain, axis=0) / np.std(weighted, axis=0)
    friction = [6, 7]  # Fv2, Fs2
    inertia = [3, 4, 5]  # ZZ2, LMX2, LMY2: seen on joint 1 as well
    assert np.all(ratio[inertia] > 2.5)
    assert np.max(ratio) > 4
    assert np.all(ratio[friction] > 1)


# --- equivariance -------------------------------------------------------------------------------------------------


@cache
def _base(path_seed: int):
    return estimate(problem(multisine(path_seed, 12.0), 3), "poly")


@pytest.mark.parametrize("gain", [1e-3, 0.37, 1e4])
def test_units_of_torque_scale_all_parameters(gain):
    found = estimate(problem(multisine(0, 12.0), 3, torque=gain), "poly")
    np.testing.assert_allclose(found.theta, gain * _base(0).theta, rtol=1e-7)
    np.testing.assert_allclose(found.sd, gain * _base(0).sd, rtol=1e-5)
    for joint, residual in found.residual.items():
        assert residual.relative == pytest.approx(_base(0).residual[joint].relative, rel=1e-6)


@pytest.mark.parametrize("gain", [1e-3, 0.37, 20.0])
def test_units_of_time_scale_inertias_and_viscous_friction(gain):
    """t -> a t: inertias by a^2, viscous friction by a, dry friction not at all; all automatic choices follow."""
    found = estimate(problem(multisine(0, 12.0), 3, time=gain), "poly")
    power = np.array([{"Z": 2, "L": 2}.get(p.name[0], {"Fv": 1, "Fs": 0}.get(p.name[:2])) for p in found.parameters])
    np.testing.assert_allclose(found.theta, gain**power * _base(0).theta, rtol=1e-5, atol=0)
    np.testing.assert_allclose(found.sd, gain**power * _base(0).sd, rtol=1e-4, atol=0)


@pytest.mark.parametrize("gain", [1e-3, 57.3])
def test_units_of_position_scale_axes(gain):
    path = multisine(0, 12.0)
    rng = np.random.default_rng(0)
    tau = 2 * path.ddq + 0.3 * path.dq + 0.5 * np.sign(path.dq) + 0.1 * rng.standard_normal(path.q.shape)
    q = path.q + white(rng, path.q.shape, ENCODER)

    def theta(scale):
        return estimate(Problem(make_model(AXES), (make_log(path.t, scale * q, tau, ["a", "b"]),)), "poly").theta

    np.testing.assert_allclose(theta(gain) * np.array([gain, gain, 1] * 2), theta(1.0), rtol=1e-5)


def test_gains_of_the_model_file_are_those_of_the_log(tmp_path):
    """A coupled transmission undone by its matrices gives what the joints themselves give."""
    from arms import write_csv

    from chebid.log import read_log

    path = multisine(0, 12.0)
    tau = planar_torque(path)
    couple = np.array([[1.0, 0.0], [-0.5, 2.0]])  # joint = couple . motor
    motor, drive = path.q @ np.linalg.inv(couple).T, tau @ couple
    names = {"position": ["m1", "m2"], "torque": ["d1", "d2"]}
    gains = {"position_gain": couple.tolist(), "torque_gain": np.linalg.inv(couple).T.tolist()}
    model = make_model(log=names | gains)
    file = write_csv(tmp_path / "m.csv", t=path.t, m1=motor[:, 0], m2=motor[:, 1], d1=drive[:, 0], d2=drive[:, 1])
    found = estimate(Problem(model, (read_log(file, model.log, model.joints, need_torque=True),)), "poly")
    plain = estimate(Problem(make_model(), (make_log(path.t, path.q, tau),)), "poly")
    np.testing.assert_allclose(found.theta, plain.theta, rtol=1e-6)  # twelve digits in the file


def test_the_joints_of_axes_do_not_see_each_other():
    path = multisine(0, 12.0)
    rng = np.random.default_rng(0)
    tau = 2 * path.ddq + 0.3 * path.dq + 0.5 * np.sign(path.dq) + 0.1 * rng.standard_normal(path.q.shape)
    settings = {"processing": {"bandwidth": 6.0, "equation_bandwidth": 4.0, "velocity_gate": 0.05, "trim": 1.0}}
    both = estimate(Problem(make_model(AXES | settings), (make_log(path.t, path.q, tau, ["a", "b"]),)), "poly")
    alone = AXES | settings | {"joints": ["b"]}
    single = estimate(Problem(make_model(alone), (make_log(path.t, path.q[:, 1:], tau[:, 1:], ["b"]),)), "poly")
    np.testing.assert_allclose(both.theta[3:], single.theta, rtol=1e-9)
    np.testing.assert_allclose(both.sd[3:], single.sd, rtol=1e-6)


# --- honesty ------------------------------------------------------------------------------------------------------


def _redraw(made: Problem):
    """Rows of a problem with another torque noise: the motion and all choices stay, so that many draws cost little."""
    (track,) = made.tracks
    clean = planar_torque(Path3(track.motion.t, track.motion.q, track.motion.dq, track.motion.ddq))

    def draw(seed, noise):
        tau = clean + noise(np.random.default_rng(seed), clean.shape, TORQUE_NOISE)
        columns = project_columns(track, made.gate, made.band.frequency, tau[:, :, None])
        return replace(made.rows, Y=columns[:, 0])

    return draw


def coverage(path: Path3, noise, draws: int = 250) -> tuple[np.ndarray, np.ndarray]:
    """Share of the draws (P,) whose 95 % interval holds the truth: by the honest deviation and by eq. 25."""
    made = problem(path, 0)
    draw, parameters = _redraw(made), made.dynamics.parameters
    honest, plain = [], []
    for seed in range(draws):
        found = solve(draw(seed, noise), parameters)
        error = np.abs(found.theta - THETA)
        honest.append(error < 1.96 * np.sqrt(np.diag(found.covariance)))
        plain.append(error < 1.96 * np.sqrt(np.diag(found.white)))
    return np.mean(honest, axis=0), np.mean(plain, axis=0)


# 250 draws of 0.95: deviation 0.014
@pytest.mark.parametrize(
    "path", [paper_moves(), paper_moves(1, moves=22), multisine(1, 20.0)], ids=["8 s", "20 s", "sines"]
)
def test_intervals_hold_the_truth_under_white_noise(path):
    honest, plain = coverage(path, white)
    assert np.all((honest > 0.90) & (honest <= 0.99)), honest.round(3)
    assert np.all((plain > 0.90) & (plain <= 0.99)), plain.round(3)


@pytest.mark.parametrize("path", [paper_moves(1, moves=22), multisine(1, 20.0)], ids=["20 s", "sines"])
def test_intervals_hold_the_truth_under_coloured_noise(path):
    honest, plain = coverage(path, coloured)
    # what has to be learnt of the colour costs 0.01 to 0.02; three deviations of chance
    assert np.all((honest > 0.89) & (honest <= 0.99)), honest.round(3)
    assert np.mean(plain) < np.mean(honest)


def test_eq_26_is_honest_where_the_degree_is_too_low():
    """Facts, section 4: when the coefficients are regressed, eq. 26 tells the scatter of the estimates."""
    made = problem(paper_moves(1, moves=22), 0, model=make_model(processing={"degree": 160}))
    assert not made.tracks[0].whole
    draw, parameters = _redraw(made), made.dynamics.parameters
    found = [solve(draw(seed, white), parameters) for seed in range(150)]
    scatter = np.std([one.theta for one in found], axis=0)
    claimed = np.mean([np.sqrt(np.diag(one.white)) for one in found], axis=0)
    np.testing.assert_allclose(claimed, scatter, rtol=0.25)  # 150 draws: 6 %


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "path"), [("poly", multisine(1, 20.0)), ("wls", paper_moves(1, moves=22))], ids=["poly", "wls"]
)
def test_intervals_hold_the_truth_from_log_to_estimate(method, path):
    """Everything drawn anew: positions, torques, and with them every automatic choice."""
    inside = []
    for seed in range(200):
        found = estimate(problem(path, seed), method)
        inside.append(np.abs(found.theta - THETA) < 1.96 * found.sd)
    share = np.mean(inside, axis=0)
    assert np.all((share > 0.89) & (share <= 1.0)), share.round(3)  # 200 draws: deviation 0.015


# --- what is reported ---------------------------------------------------------------------------------------------


def test_the_floor_of_white_noise_is_found_and_reached():
    """Right parameters on another log: the ratio is 1 within the scatter of some hundred equations."""
    ratios = []
    for seed in range(8):
        made = problem(multisine(seed, 20.0), seed)
        found = estimate(made, "poly")
        ratios.append([residual.ratio for residual in found.residual.values()])
        for joint, sd in zip(JOINTS, TORQUE_NOISE, strict=True):
            equations = made.rows.noise[JOINTS.index(joint)]
            expected = sd * np.sqrt(equations.equations / equations.samples)
            assert found.residual[joint].floor == pytest.approx(expected, rel=0.3)
    assert np.mean(ratios) == pytest.approx(1.0, abs=0.12)


def test_relative_raw_takes_every_sample():
    made = problem(multisine(0, 12.0), 0)
    found = estimate(made, "poly")
    (track,) = made.tracks
    predicted = made.dynamics.torque(track.motion, found.theta)
    for j, joint in enumerate(JOINTS):
        raw = np.linalg.norm(track.tau[:, j] - predicted[:, j]) / np.linalg.norm(track.tau[:, j])
        assert found.residual[joint].relative_raw == pytest.approx(raw, rel=1e-12)
