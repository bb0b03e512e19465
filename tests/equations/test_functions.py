"""Test functions: orthonormal where they are used, as many as there are independent equations, alive in the motion."""

import numpy as np
import pytest
from arms import make_log, make_model, multisine, paper_moves, planar_torque
from hypothesis import given
from hypothesis import strategies as st

from chebid.equations.functions import Functions, _living_in, moving_functions, stretch_bases
from chebid.equations.gate import moving
from chebid.estimators import Problem
from chebid.projection.modes import degree_modes


def problem(path, **processing):
    return Problem(make_model(processing=processing), (make_log(path.t, path.q, planar_torque(path)),))


def of(problem, band=None, gate=None):
    (track,) = problem.tracks
    used = moving(track, problem.gate if gate is None else np.asarray(gate))
    return track, used, list(moving_functions(track, used, track.valid, band or problem.band.frequency))


def whole(function: Functions, joint: int) -> np.ndarray:
    """The functions of a joint at the samples (N_s, k), zero where the equation is not looked at."""
    return np.where(function.mask[:, [joint]], function.basis @ function.mix[joint].T, 0.0)


@pytest.fixture(scope="module")
def cut():
    """q passed whole: equations are cut to the motion before they are projected."""
    made = problem(paper_moves())
    assert made.tracks[0].whole
    return made


@pytest.fixture(scope="module")
def wide():
    """A degree too low for q: equations are projected first."""
    made = problem(paper_moves(1, moves=22), degree=125)
    assert not made.tracks[0].whole
    return made


@pytest.mark.parametrize("kind", ["cut", "wide"])
def test_functions_are_orthonormal(kind, request):
    """So white noise on the torque is white on the rows, with the same deviation."""
    _, _, functions = of(request.getfixturevalue(kind))
    assert functions
    for function in functions:
        for joint in range(2):
            values = function.basis @ function.mix[joint].T if kind == "wide" else whole(function, joint)
            np.testing.assert_allclose(values.T @ values, np.eye(values.shape[1]), atol=1e-11)  # degree * eps, twice


def test_cut_functions_see_nothing_of_slow_samples(cut):
    _, used, functions = of(cut)
    for function in functions:
        np.testing.assert_array_equal(function.mask, used[function.piece])


def test_uncut_functions_live_in_the_motion(wide):
    track, used, functions = of(wide)
    for function in functions:
        np.testing.assert_array_equal(function.mask, np.repeat(track.valid[function.piece, None], 2, axis=1))
        for joint in range(2):
            values = function.basis @ function.mix[joint].T
            inside = np.sum(values[used[function.piece][:, joint]] ** 2, axis=0)
            assert np.all(inside > 0.9)


@pytest.mark.parametrize("kind", ["cut", "wide"])
def test_as_many_as_independent_equations(kind, request):
    """2 f T, T being the time of motion: fewer by those at its edges, more by one or two a stretch."""
    made = request.getfixturevalue(kind)
    track, used, functions = of(made)
    for joint in range(2):
        count = sum(len(f.mix[joint]) for f in functions)
        expected = 2 * made.band.frequency * used[:, joint].sum() / track.rate
        pieces = int(np.sum(np.diff(used[:, joint].astype(int)) == 1)) + len(functions)
        assert expected - pieces <= count <= expected + 2 * len(functions)


def test_functions_of_a_joint_come_by_frequency(cut):
    _, _, functions = of(cut)
    for function in functions:
        for mix in function.mix:
            power = mix**2 / np.sum(mix**2, axis=1, keepdims=True)
            roughness = power @ np.arange(mix.shape[1]) ** 2
            assert np.all(np.diff(roughness) > -1e-2 * roughness[-1])  # those of shared energy a little out of order


def test_rows_are_inner_products(cut):
    _, _, functions = of(cut)
    rng = np.random.default_rng(0)
    for function in functions:
        columns = rng.standard_normal((len(function.mask), 2, 3))
        columns[~function.mask] = np.nan  # what is not looked at may be anything
        for joint, rows in enumerate(function.rows(columns)):
            slow = whole(function, joint).T @ np.nan_to_num(columns[:, joint])
            np.testing.assert_allclose(rows, slow, atol=1e-11)


def test_where_all_moves_the_polynomials_themselves():
    basis = degree_modes(np.linspace(-1, 1, 200), 20).samples
    np.testing.assert_array_equal(_living_in(basis, np.ones(200, dtype=bool), True), np.eye(21))


@given(st.integers(0, 60), st.integers(120, 200), st.booleans())
def test_what_lives_in_an_interval(first, last, cut):
    """The number of functions follows the interval; they are those of largest energy in it (another road: SVD)."""
    basis = degree_modes(np.linspace(-1, 1, 200), 24).samples
    inside = (np.arange(200) >= first) & (np.arange(200) < last)
    mix = _living_in(basis, inside, cut)
    share = np.linalg.svd(basis[inside], compute_uv=False) ** 2
    assert len(mix) == np.sum(share > (0.5 if cut else 0.9))
    values = (basis @ mix.T)[inside] if cut else basis @ mix.T
    np.testing.assert_allclose(values.T @ values, np.eye(len(mix)), atol=1e-11)


@given(st.integers(20, 5000), st.floats(0.02, 0.39))
def test_stretches_share_a_record_and_stay_well_conditioned(count, band):
    path = multisine(0, duration=50, rate=100)
    (track,) = make_track_once(path)
    end, sizes = 0, []
    for piece, basis in stretch_bases(track, band * 100, count):
        assert piece.start == end and len(basis) == piece.stop - piece.start
        assert basis.shape[1] <= len(basis)
        assert basis.shape[1] - 1 <= max(3, 2.5 * np.sqrt(len(basis)))
        end = piece.stop
        sizes.append(len(basis))
    assert end == count
    assert max(sizes) - min(sizes) <= 1


_TRACKS: dict[int, list] = {}


def make_track_once(path):
    if len(path.t) not in _TRACKS:
        _TRACKS[len(path.t)] = problem(path).tracks
    return _TRACKS[len(path.t)]
