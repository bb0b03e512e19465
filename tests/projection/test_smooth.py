"""The penalised fit: exact twins, its gain, what is free, precision, and the likelihood that chooses the penalty."""

import naive
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chebid.basis import LEGENDRE
from chebid.projection import Operator, Plan
from chebid.projection.fold import HALVES, WHOLE, Fold, folds, symmetric_grid
from chebid.projection.likelihood import Tiles
from chebid.projection.modes import degree_modes, frame
from chebid.projection.spectrum import Spectrum

EPS = np.finfo(float).eps


# --- the fit itself


@pytest.mark.parametrize(("slope", "samples", "n"), [(2, 25, 9), (2, 24, 12), (1, 20, 8), (3, 21, 10), (2, 8, 11)])
@pytest.mark.parametrize("uneven", [False, True])
def test_the_same_as_the_normal_equations_in_fractions(slope: int, samples: int, n: int, uneven: bool) -> None:
    """A penalty on the derivative of order 2 + slope; also with more coefficients than samples."""
    t = np.linspace(0, 2, samples)
    if uneven:
        t = t + 0.3 * np.sin(np.pi * t) / np.pi
    x = np.sin(4 * t) + 0.1 * np.random.default_rng(0).standard_normal(samples)
    operator = Operator(t, Plan("smooth", "legendre", n, None, 1.5, slope=slope))
    order = 2 + slope
    # in time: sum r^2 + rate / (2 pi f0)^(2 m) int (x^(m))^2 dt, on a window of half-length 1 s
    weight = (samples - 1) / 2 / (2 * np.pi * 1.5) ** (2 * order)
    tau = symmetric_grid(samples) if not uneven else operator.layout.tau(0, t)
    expected = naive.penalised(tau, x, n, order, weight)
    assert operator.fit(x).coefficients[0, :, 0] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize(("slope", "band"), [(1, 0.5), (4, 1.0), (8, 1.8)])
@pytest.mark.parametrize("order", [0, 2])
def test_the_same_as_the_wiener_filter_of_the_spectrum(slope: int, band: float, order: int) -> None:
    """Covariances between all samples, and no polynomial."""
    t = np.linspace(0, 4, 101)
    x = np.sin(5 * t) + t + 0.01 * np.random.default_rng(1).standard_normal(101)
    half = 2.5
    operator = Operator(t, Plan("smooth", degree=165, penalty=half, slope=slope, band=band))
    found = operator.at_samples(operator.fit(x), order)[:, 0]
    expected = naive.wiener(t, x, half, slope, band, order)
    # accelerations of slope 1 reach beyond half the rate, where the twin goes on; and its matrices are near singular
    tolerance = {0: 1e-5, 2: 4e-3 if slope == 1 else 1e-4}[order]
    assert found == pytest.approx(expected, abs=tolerance * np.abs(expected).max())


@pytest.mark.parametrize(("slope", "band"), [(2, 0.0), (1, 0.0), (3, 0.0), (1, 0.5), (4, 3.0), (16, 5.0)])
def test_gain_inside_a_record(slope: int, band: float) -> None:
    t, half = np.arange(1001) / 100, 8.0
    plan = Plan("smooth", degree=500, penalty=half, slope=slope, band=band)
    operator = Operator(t, plan)
    for f in (2.0, 5.0, 8.0, 11.0):
        wave = np.exp(2j * np.pi * f * t)
        series = operator.fit(np.column_stack([wave.real, wave.imag]))
        out = operator.at_samples(series) @ np.array([1, 1j])
        # what the ends and the grid of frequencies leave, at the steepest part of the gain
        assert np.mean((out / wave)[200:-200]) == pytest.approx(plan.spectrum.gain(f, half), abs=2e-5)


def test_closed_form_of_the_gain() -> None:
    f = np.array([0.5, 1.0, 2.0])
    assert Spectrum(2).gain(f, 1.0) == pytest.approx(1 / (1 + f**8), rel=1e-15)
    shape = Spectrum(1, 0.5)
    assert shape.gain(f, 1.0) == pytest.approx(1 / (1 + f**4 * (1 + 4 * f**2) / 5), rel=1e-14)
    assert shape.frequency(0.5, 1.0) == pytest.approx(1.0, rel=1e-5)
    assert Spectrum(2).frequency(np.sqrt(0.5), 1.0) == pytest.approx((np.sqrt(2) - 1) ** 0.125, rel=1e-5)


@given(slope=st.sampled_from([1, 2, 4, 16]), band=st.floats(0.1, 3), half=st.floats(0.5, 5))
def test_gain_falls_from_one_to_zero_through_a_half(slope: int, band: float, half: float) -> None:
    gain = Spectrum(slope, band).gain(np.geomspace(1e-3, 1e3, 200), half)
    assert np.all(np.diff(gain) <= 0)
    assert gain[0] == pytest.approx(1, abs=1e-6)
    assert gain[-1] < 1e-6
    assert Spectrum(slope, band).gain(half, half) == pytest.approx(0.5, rel=1e-12)


@given(
    slope=st.sampled_from([1, 2, 3]), banded=st.booleans(), n=st.integers(4, 60), penalty=st.floats(0.01, 20),
    seed=st.integers(0, 999),
)  # fmt: skip
def test_free_polynomials_are_reproduced(slope: int, banded: bool, n: int, penalty: float, seed: int) -> None:
    """Polynomials below degree 2 + slope, straight lines when the spectrum has a band: whatever the penalty."""
    t = np.linspace(0, 5, 80)
    free = 2 if banded else min(2 + slope, n + 1)
    c = np.random.default_rng(seed).standard_normal(free)
    x = LEGENDRE.evaluate(symmetric_grid(80), c)
    plan = Plan("smooth", "legendre", n, None, penalty, slope=slope, band=1.0 if banded else 0.0)
    found = Operator(t, plan).fit(x).coefficients[0, :, 0]
    assert found[:free] == pytest.approx(c, abs=1e-10)
    assert found[free:] == pytest.approx(np.zeros(n + 1 - free), abs=1e-10)


def test_a_loose_penalty_gives_least_squares_and_a_tight_one_the_free_cubic() -> None:
    t = np.linspace(0, 3, 200)
    x = np.sin(9 * t) + 0.1 * np.random.default_rng(0).standard_normal(200)
    loose = Operator(t, Plan("smooth", degree=20, penalty=1e3)).fit(x).coefficients
    assert loose == pytest.approx(Operator(t, Plan("lsq", degree=20)).fit(x).coefficients, abs=1e-9)
    tight = Operator(t, Plan("smooth", degree=20, penalty=1e-3)).fit(x).coefficients[0]
    cubic = Operator(t, Plan("lsq", degree=3)).fit(x).coefficients[0]
    assert tight[:4] == pytest.approx(cubic, abs=1e-9)
    assert tight[4:] == pytest.approx(np.zeros((17, 1)), abs=1e-9)


@pytest.mark.parametrize(
    ("n", "samples", "half"), [(250, 1001, 5.0), (700, 1001, 5.0), (1700, 1001, 5.0), (41, 31, 1.0)]
)
def test_any_degree_stays_sound(n: int, samples: int, half: float) -> None:
    """The degree that broke it once (n = 250 on 1001 samples), and degrees beyond the number of samples."""
    t = np.linspace(0, 10, samples)
    x = np.sin(2 * t)
    operator = Operator(t, Plan("smooth", degree=n, penalty=half))
    for order, scale in ((0, 1), (1, 2), (2, 4)):
        found = operator.at_samples(operator.fit(x), order)[:, 0]
        expected = scale * np.sin(2 * t + order * np.pi / 2)
        # (f / f0)^8 of it is lost inside, and more at the ends, where the penalty lets the fifth derivative go to zero
        loss = (1 / np.pi / half) ** (4 - order)
        assert found == pytest.approx(expected, abs=4 * loss * scale)
        assert found[len(t) // 4 : -len(t) // 4] == pytest.approx(expected[len(t) // 4 : -len(t) // 4], abs=0.02 * loss)


def test_end_noise_is_tamed() -> None:
    """Where plain least squares has 1.3e7 at the end (n = 125, 10 s at 100 Hz), the penalty has a thousandth."""
    t = np.arange(1001) / 100
    plain = Operator(t, Plan("lsq", degree=125)).noise_gain(2)
    assert plain[0] == pytest.approx(1.3e7, rel=0.05)
    assert plain[500] == pytest.approx(80, rel=0.05)
    tamed = Operator(t, Plan("smooth", degree=125, penalty=4.4)).noise_gain(2)
    assert tamed[0] < 1e-3 * plain[0]
    assert tamed[500] == pytest.approx(plain[500], rel=0.2)


def test_degrees_of_freedom_are_the_trace() -> None:
    t = np.linspace(0, 2, 30)
    for plan in (Plan("smooth", degree=12, penalty=2.0), Plan("smooth", degree=20, penalty=2.0, slope=4, band=1.0)):
        operator = Operator(t, plan)
        h = operator.at_samples(operator.fit(np.eye(30)))
        assert operator.freedom * 30 == pytest.approx(np.trace(h), rel=1e-12)
        assert h == pytest.approx(h.T, abs=1e-12)
        values = np.linalg.eigvalsh(h)
        assert values[0] > -1e-12
        assert values[-1] < 1 + 1e-12


# --- the parts


def test_folds_split_and_rotate() -> None:
    x = np.random.default_rng(0).standard_normal((3, 11))
    parts = [fold.samples(x) for fold in HALVES]
    assert sum(part.shape[1] for part in parts) == 11
    energy = sum(np.sum(part**2, axis=1) for part in parts)
    assert energy == pytest.approx(np.sum(x**2, axis=1), rel=1e-14)
    for samples in (10, 11):
        tau = symmetric_grid(samples)
        for fold in HALVES:
            whole = LEGENDRE.values(tau, 7)[:, fold.degrees(7)]
            assert fold.polynomials(LEGENDRE, tau, 7) == pytest.approx(fold.samples(whole.T).T, abs=1e-14)
            assert fold.rows(samples) == fold.polynomials(LEGENDRE, tau, 7).shape[0]
            rows = slice(2, 4)
            some = fold.polynomials(LEGENDRE, tau, 7, rows)
            assert some == pytest.approx(fold.polynomials(LEGENDRE, tau, 7)[rows], abs=1e-15)


def test_only_symmetric_grids_fold() -> None:
    assert folds(symmetric_grid(9)) == HALVES
    assert folds(np.array([-1.0, 0.1, 1.0])) == WHOLE


@pytest.mark.parametrize(("samples", "n"), [(400, 30), (50, 45), (30, 60)])
def test_frames_are_orthonormal(samples: int, n: int) -> None:
    tau = np.sort(np.random.default_rng(0).uniform(-1, 1, samples))
    made = frame(tau, n, Fold())
    k = min(samples, n + 1)
    assert made.samples.T @ made.samples == pytest.approx(np.eye(k), abs=1e-13)
    values = LEGENDRE.values(tau, n)
    assert made.samples @ made.triangle == pytest.approx(values, abs=1e-12)


def test_degree_modes_are_nested() -> None:
    tau = np.linspace(-1, 1, 60) ** 3
    few, many = degree_modes(tau, 5).samples, degree_modes(tau, 9).samples
    assert np.abs(few.T @ many[:, :6]) == pytest.approx(np.eye(6), abs=1e-12)


@pytest.mark.parametrize("plan", [Plan("smooth", degree=60, penalty=0.6), Plan("lsq", degree=30, window=5.0)], ids=str)
@pytest.mark.parametrize("uneven", [False, True])
def test_records_too_long_to_keep_their_polynomials(monkeypatch: pytest.MonkeyPatch, plan: Plan, uneven: bool) -> None:
    t = np.arange(3000) / 100 + (0.002 * np.sin(np.arange(3000.0) ** 2) if uneven else 0)
    x = np.column_stack([np.sin(t), np.cos(2 * t) + 0.1 * np.random.default_rng(0).standard_normal(3000)])
    kept = Operator(t, plan)
    expected = kept.fit(x).coefficients
    monkeypatch.setattr("chebid.projection.modes._STORED", 100)
    streamed = Operator(t, plan)
    assert streamed.fit(x).coefficients == pytest.approx(expected, abs=1e-10)
    assert streamed.noise_gain(1) == pytest.approx(kept.noise_gain(1), rel=1e-9)


# --- likelihood


@pytest.mark.parametrize(("slope", "share"), [(2, 0.0), (1, 0.0), (1, 0.2), (16, 0.6)])
def test_likelihood_is_that_of_the_covariance_matrix(slope: int, share: float) -> None:
    samples, n = 40, 16
    x = np.random.default_rng(2).standard_normal((3, samples)) + np.sin(np.linspace(0, 7, samples))
    shape = Spectrum(slope, share * n / np.pi)
    tau = symmetric_grid(samples)
    polynomials = LEGENDRE.values(tau, n)
    for half in (1.0, 3.0):
        weight = float(shape.weight(half, samples - 1))
        motion = polynomials @ shape.columns(n) / np.sqrt(weight)
        free = polynomials[:, : shape.null]
        # one tile is the textbook formula; of several, logs add up and so do squares
        one = Tiles(x[:1], 1.0, n, 1e-15)._scores(shape, np.array([[weight]]))[0]
        assert one == pytest.approx(naive.restricted_likelihood(x[0], motion @ motion.T, free), abs=1e-9)
        block = np.kron(np.eye(3), motion)
        several = Tiles(x, 1.0, n, 1e-15)._scores(shape, np.array([[weight]]))[0]
        expected = naive.restricted_likelihood(x.ravel(), block @ block.T, np.kron(np.eye(3), free))
        assert several == pytest.approx(expected, abs=1e-9)


def test_the_most_likely_half_gain_frequency_is_where_signal_and_noise_are_equal() -> None:
    """A random motion of known spectrum in known noise: f0 within a tenth, slope and band as they were made."""
    random = np.random.default_rng(3)
    samples, n, tiles = 320, 125, 100
    rate, half, band = 100.0, 6.0, 2.0
    f = (np.arange(4000) + 0.5) * 0.0125
    strength = (half / f) ** 4 * (1 + (half / band) ** 2) / (1 + (f / band) ** 2)  # over the noise
    t = np.arange(samples) / rate
    x = random.standard_normal((tiles, samples))
    phases = random.uniform(0, 2 * np.pi, (tiles, len(f)))
    amplitude = np.sqrt(2 * random.exponential(size=(tiles, len(f))) * strength * 2 * 0.0125 / rate)
    amplitude[:, f < 0.05] = 0  # moves by miles: a straight line on a tile
    for k in range(len(f)):
        x += amplitude[:, k : k + 1] * np.cos(2 * np.pi * f[k] * t + phases[:, k : k + 1])
    seen = Tiles(x, rate, n, 1e-15)
    shapes = [(slope, share) for slope in (1, 2, 4) for share in (0.04, 0.08, 0.16, 0.32)]
    found = seen.best(shapes)
    assert (found.spectrum.slope, found.spectrum.band) == (1, pytest.approx(0.16 * seen.cut))
    assert found.half == pytest.approx(half, rel=0.1)
