"""The variance of a residual as a function of frequency: known spectra come back, parameters are counted off."""

import numpy as np
import pytest

from chebid.estimators.restricted import restricted_variance
from chebid.estimators.spectrum import spectrum

ROWS = 120
FREQUENCY = np.linspace(0.1, 10.0, ROWS)


def regressor(random: np.random.Generator, count: int = 5) -> np.ndarray:
    """Columns that live at low frequency, as those of a motion."""
    return random.standard_normal((ROWS, count)) * np.exp(-FREQUENCY / 2)[:, None]


def _squares(X, y, frequency):
    return spectrum(X, y, frequency).variance


@pytest.mark.parametrize("found_by", [restricted_variance, _squares])
@pytest.mark.parametrize("slope", [-0.4, 0.0, 0.4])
def test_known_spectra_come_back(slope, found_by):
    """log v linear in the frequency, which no polynomial in its root is quite; 100 draws leave 3 % of chance."""
    truth = 0.3 * np.exp(slope * FREQUENCY)
    logs = []
    for seed in range(100):
        random = np.random.default_rng(seed)
        X = regressor(random)
        y = X @ np.arange(5.0) + np.sqrt(truth) * random.standard_normal(ROWS)
        logs.append(np.log(found_by(X, y, FREQUENCY)))
    off = np.mean(logs, axis=0) - np.log(truth)
    assert np.all(np.abs(off[5:]) < 0.25), off.round(2)
    assert abs(np.mean(off)) < 0.05


def test_white_noise_has_the_variance_of_least_squares():
    """Whenever the criterion finds nothing to tell: the sum of squares over rows less parameters, exactly."""
    flat = 0
    for seed in range(20):
        random = np.random.default_rng(seed)
        X, y = regressor(random), random.standard_normal(ROWS)
        found = spectrum(X, y, FREQUENCY)
        variance, unsure = found.variance, found.unsure
        residual = y - X @ np.linalg.lstsq(X, y)[0]
        if np.ptp(variance) == 0:
            flat += 1
            assert variance[0] == pytest.approx(residual @ residual / (ROWS - 5), rel=1e-6)
            assert np.sum(unsure[0] ** 2) == pytest.approx(2 / (ROWS - 5))
    assert flat >= 12  # Akaike's criterion takes a constant in some 80 of 100 cases


def test_scale_comes_out_squared():
    random = np.random.default_rng(3)
    X, y = regressor(random), np.exp(-FREQUENCY / 3) * random.standard_normal(ROWS)
    one = spectrum(X, y, FREQUENCY).variance
    other = spectrum(1e4 * X, 1e-3 * y, 50 * FREQUENCY).variance
    np.testing.assert_allclose(other, 1e-6 * one, rtol=1e-4)


def test_few_rows_and_columns_of_zeros():
    random = np.random.default_rng(0)
    X = np.hstack([random.standard_normal((9, 3)), np.zeros((9, 2))])
    variance = spectrum(X, X @ np.ones(5) + random.standard_normal(9), np.linspace(1, 2, 9)).variance
    assert np.ptp(variance) == 0 and variance[0] > 0


def test_an_exact_fit_has_no_variance():
    X = regressor(np.random.default_rng(1))
    found = spectrum(X, X @ np.ones(5), FREQUENCY)
    assert np.all(found.variance < 1e-24) and np.isfinite(found.unsure).all()


def test_parameters_that_take_a_frequency_whole_leave_no_more_than_others_show():
    """A model with many parameters and a fault: where no residual is left, the variance follows its neighbours."""
    random = np.random.default_rng(5)
    X = np.hstack([np.eye(ROWS)[:, :6], regressor(random, 25)])
    y = random.standard_normal(ROWS) + 3 * np.exp(-(((FREQUENCY - 1.5) / 0.3) ** 2))
    assert np.max(spectrum(X, y, FREQUENCY).variance) < 20
