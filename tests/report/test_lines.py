"""Long lines: few points, every peak."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from chebid.report.lines import envelope


@given(st.integers(10, 3000), st.integers(2, 200), st.integers(0, 2**32 - 1))
def test_every_peak_is_drawn(count, most, seed):
    rng = np.random.default_rng(seed)
    t, y = np.arange(float(count)), rng.standard_normal(count)
    peak = rng.integers(count)
    y[peak] = 9.0
    points, values = envelope(t, y, most)
    assert len(points) == len(values) <= 2 * most
    assert np.all(np.diff(points) >= 0)
    assert values.max() == 9.0 and points[values.argmax()] == peak
    assert values.min() == y.min()
    np.testing.assert_array_equal(y[points.astype(int)], values)


def test_a_gap_stays_a_gap():
    t = np.arange(1000.0)
    y = np.where(t == 500, np.nan, np.sin(t / 50))
    _, values = envelope(t, y, 50)
    assert np.isnan(values).sum() == 1
