"""Rows by the classical recipe: decimation, differences, records, delay, and what must be refused.

That the recipe is the published one is shown by the digits of `test_emps.py`.
"""

import numpy as np
import pytest
import scipy.signal
from arms import JOINTS, THETA, join_records, make_log, make_model, multisine, planar_torque

from chebid.dynamics import make_dynamics
from chebid.equations import FilterSettings, filtered_rows
from chebid.equations.filtered import decimate, filtered_motion
from chebid.errors import NoAnswerError

DYNAMICS = make_dynamics(make_model())


def records_of(path, tau=None):
    return list(make_log(path.t, path.q, planar_torque(path) if tau is None else tau).records)


@pytest.mark.parametrize(("count", "factor", "kept"), [(24792, 10, 2480), (100, 10, 10), (101, 10, 11), (99, 7, 15)])
def test_decimation_keeps_the_last_sample(count, factor, kept):
    """A slow sine of known phase tells which samples were kept."""
    index = np.arange(float(count))
    thin = decimate(np.sin(0.1 * index / factor)[:, None], factor)[:, 0]
    first = (count - 1) % factor
    assert len(thin) == kept
    # one sample off is 0.1 / factor; the filter passes 0.05 dB less, twice, and knows no ends
    middle = slice(kept // 3, -(kept // 3))
    expected = np.sin(0.1 * index[first::factor] / factor)[middle]
    gain = expected @ thin[middle] / (expected @ expected)
    np.testing.assert_allclose(thin[middle] / gain, expected, atol=0.02 / factor if count > 1000 else 0.05)


def test_decimation_against_another_road():
    """Every tenth sample of the filter in the frequency domain, far from the ends."""
    rng = np.random.default_rng(0)
    x = rng.standard_normal(4000)
    sections = scipy.signal.cheby1(8, 0.05, 0.8 / 10, output="sos")
    _, gain = scipy.signal.sosfreqz(sections, 2001, fs=2.0)
    spectrum = np.fft.rfft(x)
    response = np.interp(np.linspace(0, 1, len(spectrum)), np.linspace(0, 1, 2001, endpoint=False), np.abs(gain) ** 2)
    slow = np.fft.irfft(spectrum * response)[9::10]
    np.testing.assert_allclose(decimate(x[:, None], 10)[50:-50, 0], slow[50:-50], atol=2e-3)  # response interpolated


def test_differences_are_exact_on_a_parabola():
    """Second-order differences, twice: exact away from the ends, where the filter starts."""
    t = np.arange(2000) / 100
    q = np.column_stack([0.3 + 0.2 * t - 0.05 * t**2, 1 - t + 0.1 * t**2])
    record = make_log(t, q, np.zeros_like(q)).records[0]
    for parallel in (False, True):
        settings = FilterSettings(cutoff=20.0, parallel=parallel)
        _, motion, _ = filtered_motion(record, settings)
        inner = slice(300, -300)
        np.testing.assert_allclose(motion.dq[inner], np.column_stack([0.2 - 0.1 * t, -1 + 0.2 * t])[inner], atol=1e-9)
        np.testing.assert_allclose(motion.ddq[inner], np.array([[-0.1, 0.2]]).repeat(1400, 0), atol=1e-7)


def test_parallel_filtering_is_without_the_bias_of_second_order_differences():
    path = multisine(0, 20.0)

    def error(parallel):
        settings = FilterSettings(cutoff=8.0, trim=1.0, gate=(0.05, 0.05), parallel=parallel)
        rows = filtered_rows(records_of(path), DYNAMICS, settings)
        return np.abs(np.linalg.lstsq(rows.W, rows.Y)[0] / THETA - 1)

    assert error(True)[0] < 5e-4
    assert error(False)[0] > 5e-4


def test_records_are_never_joined():
    first, second = multisine(0, 8.0), multisine(1, 8.0)
    parts = [(p.t + shift, p.q + shift, planar_torque(p)) for p, shift in ((first, 0.0), (second, 9.0))]
    settings = FilterSettings(cutoff=10.0, decimate=4, drop=30)
    log = join_records(parts, JOINTS)
    both = filtered_rows(list(log.records), DYNAMICS, settings)
    alone = [filtered_rows([record], DYNAMICS, settings) for record in log.records]
    np.testing.assert_array_equal(both.Y, np.concatenate([rows.Y for rows in alone]))
    assert both.noise[0].samples == sum(rows.noise[0].samples for rows in alone)


def test_a_missing_sample_and_uneven_stamps_are_bridged():
    path = multisine(0, 20.0)
    rng = np.random.default_rng(0)
    tau = planar_torque(path)
    whole = filtered_rows(records_of(path), DYNAMICS, FilterSettings(cutoff=5.0, trim=1.0))
    q = path.q.copy()
    q[500], tau[900] = np.nan, np.nan
    t = path.t + 1e-4 * rng.uniform(-1, 1, len(path.t))
    rows = filtered_rows(list(make_log(t, q, tau).records), DYNAMICS, FilterSettings(cutoff=5.0, trim=1.0))
    assert np.isfinite(rows.W).all() and np.isfinite(rows.Y).all()
    there, here = (np.linalg.lstsq(r.W, r.Y)[0] for r in (whole, rows))
    np.testing.assert_allclose(here[[0, 3, 4]], there[[0, 3, 4]], rtol=0.01)  # 1e-4 s of 10 rad/s in the positions


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (FilterSettings(cutoff=50.0), "cutoff of 50 Hz is not below half the rate, 50 Hz"),
        (FilterSettings(cutoff=10.0, drop=2000), "too few samples are left"),
        (FilterSettings(cutoff=10.0, trim=99.0), "too few samples are left"),
        (FilterSettings(cutoff=10.0, gate=(0.0, 1e3)), "joint q2 has no sample left"),
    ],
)
def test_what_leaves_nothing_is_refused(settings, message):
    with pytest.raises(NoAnswerError, match=message) as caught:
        filtered_rows(records_of(multisine(0, 10.0)), DYNAMICS, settings)
    assert caught.value.hint
