"""What holds for every operator: linear, blended as stated, indifferent to units, true to uneven stamps; its guards."""

import tracemalloc

import naive
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chebid.basis import CHEBYSHEV, FAMILIES, LEGENDRE
from chebid.errors import NoAnswerError, UsageError
from chebid.projection import FITS, Layout, Operator, Plan, from_bandwidth
from chebid.projection.clock import is_uniform, rate_of
from chebid.projection.layout import divide

EPS = np.finfo(float).eps
PLANS = {
    "lsq": Plan("lsq", degree=20),
    "lsq, legendre": Plan("lsq", "legendre", 20),
    "lsq, windows": Plan("lsq", degree=9, window=1.3),
    "quadrature": Plan("quadrature", "chebyshev2", 15),
    "quadrature, windows": Plan("quadrature", degree=9, window=1.3),
    "smooth": Plan("smooth", degree=40, penalty=3.0),
    "smooth, band": Plan("smooth", "legendre", 60, None, 4.0, slope=16, band=2.0),
    "smooth, windows": Plan("smooth", degree=30, window=1.3, penalty=6.0, slope=4, band=2.0),
}
plans = st.sampled_from(sorted(PLANS))
clocks = st.sampled_from(["uniform", "odd", "uneven"])


def clock(kind: str) -> np.ndarray:
    t = 100 + np.arange(400 if kind == "uniform" else 401) / 80
    return t + 0.004 * np.sin(np.arange(401) ** 2) if kind == "uneven" else t


def noise(samples: int, signals: int = 1, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).standard_normal((samples, signals))


# --- linear maps


@given(kind=clocks, name=plans, a=st.floats(-100, 100), b=st.floats(-100, 100), order=st.integers(0, 3))
def test_linear_and_every_signal_for_itself(kind: str, name: str, a: float, b: float, order: int) -> None:
    t = clock(kind)
    operator, x = Operator(t, PLANS[name]), noise(len(t), 3)
    x[:, 2] = a * x[:, 0] + b * x[:, 1]
    together = operator.at_samples(operator.fit(x), order)
    scale = np.abs(together).max() * (abs(a) + abs(b) + 1)
    assert together[:, 2] == pytest.approx(a * together[:, 0] + b * together[:, 1], abs=1e-11 * scale)
    alone = operator.at_samples(operator.fit(x[:, 1]), order)
    # the quadrature sums jumps of slope, which are some hundred times the signal, and U_n is n at the ends
    assert alone == pytest.approx(together[:, 1:2], abs=1e-10 * np.abs(together).max())


@pytest.mark.parametrize("name", PLANS)
@pytest.mark.parametrize("kind", ["uniform", "odd", "uneven"])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_at_samples_is_the_series_at_the_samples(name: str, kind: str, order: int) -> None:
    t = clock(kind)
    operator = Operator(t, PLANS[name])
    series = operator.fit(noise(len(t), 2))
    slow = series(t, order)
    assert operator.at_samples(series, order) == pytest.approx(slow, abs=1e-11 * np.abs(slow).max())
    some = slice(57, 203)
    assert series(t[some], order) == pytest.approx(slow[some], abs=1e-11 * np.abs(slow).max())
    assert series(t[:0], order).shape == (0, 2)


@pytest.mark.parametrize("name", [name for name in PLANS if name.startswith("lsq") and "windows" not in name])
def test_least_squares_is_idempotent(name: str) -> None:
    t = clock("odd")
    operator = Operator(t, PLANS[name])
    once = operator.at_samples(operator.fit(noise(401)))
    assert operator.at_samples(operator.fit(once)) == pytest.approx(once, abs=1e-12)


@given(name=plans, kind=clocks, order=st.integers(0, 3))
def test_time_turned_round(name: str, kind: str, order: int) -> None:
    """x(-t): derivatives of odd order change their sign."""
    t, x = clock(kind), noise(len(clock(kind)))[:, 0]
    there = Operator(t, PLANS[name])
    back = Operator(-t[::-1], PLANS[name])
    a = there.at_samples(there.fit(x), order)
    b = back.at_samples(back.fit(x[::-1]), order)[::-1] * (-1) ** order
    # tau of both differs in its last digits, which high derivatives see
    assert a == pytest.approx(b, abs=1e-9 * np.abs(a).max())


@given(
    name=plans, kind=clocks, order=st.integers(0, 2), unit=st.floats(1e-6, 1e6), start=st.floats(-50, 50),
    gain=st.floats(1e-9, 1e9), offset=st.floats(-1e3, 1e3),
)  # fmt: skip
def test_units_of_time_and_of_the_signal(
    name: str, kind: str, order: int, unit: float, start: float, gain: float, offset: float
) -> None:
    """d^k (g x + o) / d(u t)^k = g u^-k d^k x / dt^k, and o for k = 0."""
    t, x, plan = clock(kind), noise(len(clock(kind)))[:, 0], PLANS[name]
    from dataclasses import replace

    other = replace(plan, window=plan.window and plan.window * unit, penalty=plan.penalty / unit, band=plan.band / unit)
    one, two = Operator(t, plan), Operator((t - 100 + start) * unit, other)
    a = one.at_samples(one.fit(x), order) * gain * unit**-order
    b = two.at_samples(two.fit(gain * x + offset * gain), order) - (offset * gain if order == 0 else 0)
    assert b == pytest.approx(a, abs=1e-7 * np.abs(a).max())  # the stamps of an uneven clock are rounded anew


def test_a_large_offset_costs_no_digits_of_the_motion() -> None:
    t = np.arange(1001) / 100
    motion = 1e-3 * np.sin(6 * t)
    for plan in (Plan("lsq", degree=40), Plan("smooth", degree=80, penalty=4.0), Plan("quadrature", degree=40)):
        operator = Operator(t, plan)
        small = operator.at_samples(operator.fit(motion), 2)
        large = operator.at_samples(operator.fit(1e5 + motion), 2)
        # the samples themselves have lost 1e5 EPS; the noise gain of the acceleration multiplies that
        assert large == pytest.approx(small, abs=1e5 * EPS * operator.noise_gain(2).max() * 30)


# --- uneven stamps


@pytest.mark.parametrize(
    "plan", [Plan("lsq", degree=40), Plan("lsq", degree=25, window=3.0), Plan("smooth", degree=60, penalty=5.0),
             Plan("quadrature", degree=60)], ids=str,
)  # fmt: skip
def test_uneven_stamps_are_used_as_they_are(plan: Plan) -> None:
    """A step that grows tenfold along the record; to pretend a mean step would give another motion altogether."""
    u = np.linspace(0, 1, 2001)
    t = 10 * (0.1 * u + 0.45 * u**2) / 0.55
    x, expected = np.sin(5 * t), 5 * np.cos(5 * t)
    operator = Operator(t, plan)
    assert not operator.uniform
    inner = slice(200, -200)
    found = operator.at_samples(operator.fit(x), 1)[:, 0]
    tolerance = 0.02 if plan.fit == "quadrature" else 1e-4  # straight lines between samples: (w h)^2 / 12, then n^2
    assert found[inner] == pytest.approx(expected[inner], abs=5 * tolerance)
    pretended = Operator(np.linspace(0, 10, 2001), plan)
    wrong = pretended.at_samples(pretended.fit(x), 1)[:, 0]
    assert np.abs(wrong - expected)[inner].max() > 3


def test_what_counts_as_uniform() -> None:
    t = np.arange(1000) / 1000
    assert is_uniform(t)
    assert is_uniform(t + 1.7e9)  # stamps since 1970, in double precision
    assert is_uniform(np.round(t, 7))
    assert not is_uniform(t + 1e-6 * np.sin(np.arange(1000)))
    assert not is_uniform(np.delete(t, 500))
    assert rate_of(t) == pytest.approx(1000)


# --- windows


@given(samples=st.integers(24, 3000), share=st.floats(0.01, 2.0))
def test_windows_fit_the_record(samples: int, share: float) -> None:
    """Equal, half-overlapping about, from the first sample to the last, and on whole steps of a uniform grid."""
    t = 5 + np.arange(samples) / 50
    span = t[-1] - t[0]
    layout = divide(t, share * span)
    assert layout.start[0] == pytest.approx(t[0])
    assert layout.stop[-1] == pytest.approx(t[-1])
    assert np.ptp(layout.half) < 1e-9
    if layout.count > 1:
        steps = (layout.start - t[0]) * 50
        assert steps == pytest.approx(np.round(steps), abs=1e-6)
        overlap = (layout.stop[:-1] - layout.start[1:]) / (2 * layout.half[0])
        assert np.all(overlap > 0.3)


@given(samples=st.integers(24, 2000), share=st.floats(0.02, 0.6), seed=st.integers(0, 99))
def test_weights_of_the_blend_sum_to_one(samples: int, share: float, seed: int) -> None:
    t = np.sort(np.random.default_rng(seed).uniform(0, 7, samples))
    layout = divide(t, share * (t[-1] - t[0]))
    total = np.zeros(samples)
    for window in layout.touched(t):
        where = layout.active(window, t)
        total[where] += layout.weight(window, t[where])
        assert np.all(np.abs(layout.tau(window, t[where])) < 1 + 1e-9)
    assert total == pytest.approx(np.ones(samples), abs=1e-12)


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize("order", [0, 2])
def test_windows_by_direct_evaluation(uneven: bool, order: int) -> None:
    t = np.arange(301) / 50 + (0.005 * np.sin(np.arange(301) ** 2) if uneven else 0)
    x = noise(301)[:, 0]
    operator = Operator(t, Plan("lsq", "legendre", 7, 1.7))
    layout = operator.layout
    windows = list(zip(layout.start, layout.stop, strict=True))
    assert len(windows) > 3
    values = []
    for start, stop in windows:
        inside = (t >= start - 0.005) & (t <= stop + 0.005)
        scale = 2 / (stop - start)
        tau = np.clip((t[inside] - (start + stop) / 2) * scale, -1, 1)
        c = naive.pseudo_inverse("legendre", tau, x[inside], 7)
        derivative = np.polynomial.legendre.legder(c, order) * scale**order
        values.append(
            lambda at, a=start, b=stop, d=derivative: np.polynomial.legendre.legval((2 * at - a - b) / (b - a), d)
        )
    expected = naive.blended(t, windows, values)
    found = operator.at_samples(operator.fit(x), order)[:, 0]
    assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())


def test_windows_in_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    t, x = np.arange(3001) / 100, noise(3001, 3)
    operator = Operator(t, PLANS["smooth, windows"])
    whole = operator.at_samples(operator.fit(x), 1)
    monkeypatch.setattr("chebid.projection.comb._BATCH", 500)
    assert operator.at_samples(operator.fit(x), 1) == pytest.approx(whole, abs=1e-11 * np.abs(whole).max())


def test_blends_do_not_show() -> None:
    """A motion that the windows resolve comes out the same inside blends and between them."""
    t = np.arange(6001) / 100
    x = np.sin(2 * np.pi * 1.2 * t)
    operator = Operator(t, Plan("smooth", degree=60, window=6.0, penalty=8.0))
    error = np.abs(operator.at_samples(operator.fit(x), 2)[:, 0] + (2 * np.pi * 1.2) ** 2 * x)[300:-300]
    assert error.max() < 1e-4 * (2 * np.pi * 1.2) ** 2


# --- noise


@pytest.mark.parametrize("name", [name for name in PLANS if "quadrature" not in name])
@pytest.mark.parametrize("kind", ["uniform", "uneven"])
@pytest.mark.parametrize("order", [0, 1, 2])
def test_noise_gain_is_that_of_the_map(name: str, kind: str, order: int) -> None:
    t, plan = clock(kind), PLANS[name]
    operator = Operator(t, plan)
    rows = operator.at_samples(operator.fit(np.eye(len(t))), order)
    expected = np.linalg.norm(rows, axis=1)
    found = operator.noise_gain(order)
    if operator.layout.count == 1:
        assert found == pytest.approx(expected, rel=1e-6)
    else:  # in blends an upper bound: the noises of two windows are not the same
        assert np.all(found >= expected * (1 - 1e-6))
        assert np.all(found <= expected * 1.5)
        assert np.median(found / expected) < 1.05


def test_long_windows_have_their_noise_from_fewer_points() -> None:
    t = np.arange(4001) / 100
    operator = Operator(t, Plan("lsq", degree=40))
    few = operator.noise_gain(2)
    all_of_them = np.sqrt(operator._squared_gains(0, operator._tau(0), (2,)))[0]
    assert few == pytest.approx(all_of_them, rel=1e-4)  # squares span eleven decades


@pytest.mark.parametrize(("order", "exponent", "outer"), [(1, -0.75, 0.11), (2, -1.25, 0.17)])
def test_growth_of_noise_toward_the_ends(order: int, exponent: float, outer: float) -> None:
    """The local cut-off fc / sqrt(1 - tau^2): noise as (1 - tau^2)^(-3/4) and ^(-5/4), twice at 11 % and 17 %."""
    t = np.linspace(0, 1, 4001)
    gain = Operator(t, Plan("lsq", degree=60)).noise_gain(order)
    tau = 2 * t - 1
    inner = np.abs(tau) < 0.9
    slope = np.polyfit(np.log(1 - tau[inner] ** 2), np.log(gain[inner]), 1)[0]
    assert slope == pytest.approx(exponent, rel=0.03)
    beyond = gain > 2 * gain[1900:2100].mean()
    assert np.argmin(beyond) / 4001 == pytest.approx(outer, abs=0.015)


def test_local_cutoff_of_polynomials() -> None:
    """A degree that passes f in the middle passes f / sqrt(1 - tau^2) at tau."""
    t, n = np.linspace(0, 10, 4001), 80
    operator = Operator(t, Plan("lsq", degree=n))
    fc = n / (np.pi * 10)
    f = 1.25 * fc  # passes beyond |tau| = 0.6
    wave = np.exp(2j * np.pi * f * t)
    out = operator.at_samples(operator.fit(np.column_stack([wave.real, wave.imag]))) @ np.array([1, 1j])
    tau = np.abs(t / 5 - 1)
    gain = (out / wave).real
    assert gain[tau < 0.5].mean() == pytest.approx(0, abs=0.05)
    assert gain[(tau > 0.55) & (tau < 0.65)].mean() == pytest.approx(0.5, abs=0.05)
    assert gain[tau > 0.7].mean() == pytest.approx(1, abs=0.05)


# --- guards


def test_degree_against_samples() -> None:
    t = np.arange(101) / 100
    for fit, most in (("lsq", 40), ("quadrature", 40), ("smooth", 172)):
        Operator(t, Plan(fit, degree=most, penalty=5.0))
        with pytest.raises(NoAnswerError, match=f"degree {most + 1} is too high for 101 samples") as caught:
            Operator(t, Plan(fit, degree=most + 1, penalty=5.0))
        assert "lower degree" in caught.value.hint
    with pytest.raises(NoAnswerError, match="too high for 21 samples"):
        Operator(t, Plan(degree=20, window=0.2))


def test_unknown_fit_and_basis() -> None:
    t = np.arange(10.0)
    with pytest.raises(UsageError, match="unknown fit 'spline'") as caught:
        Operator(t, Plan("spline", degree=2))
    assert all(fit in caught.value.hint for fit in FITS)
    with pytest.raises(UsageError, match="unknown basis 'hermite'"):
        Operator(t, Plan("lsq", "hermite", 2))


@pytest.mark.parametrize("bandwidth", [0.0, -1.0, 50.0, float("nan")])
def test_bandwidth_against_rate(bandwidth: float) -> None:
    with pytest.raises(UsageError, match="is not between 0 and half the rate, 50 Hz"):
        from_bandwidth(np.arange(1001) / 100, bandwidth)


@pytest.mark.parametrize("fit", FITS)
@pytest.mark.parametrize("bandwidth", [0.05, 1.0, 4.0, 15.0, 35.0, 49.0])
def test_any_bandwidth_can_be_carried_out(fit: str, bandwidth: float) -> None:
    for samples in (60, 1001, 20_000):
        t = np.arange(samples) / 100
        operator = Operator(t, from_bandwidth(t, bandwidth, fit))
        out = operator.at_samples(operator.fit(np.ones(samples)))
        assert out == pytest.approx(np.ones((samples, 1)), abs=1e-11)


# --- size


@pytest.mark.parametrize(
    "plan", [Plan("lsq", degree=125), Plan("quadrature", degree=60), Plan("smooth", degree=125, penalty=0.05),
             Plan("smooth", degree=100, window=5.0, penalty=5.0), Plan("lsq", degree=100, window=5.0)], ids=str,
)  # fmt: skip
def test_memory_is_that_of_a_few_copies_of_the_record(plan: Plan) -> None:
    samples = 300_000
    t = np.arange(samples) / 1000
    x = np.sin(t)
    Operator(t[:20_000], plan).fit(x[:20_000])  # what is kept between calls does not count
    tracemalloc.start()
    operator = Operator(t, plan)
    operator.at_samples(operator.fit(x), 2)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 30e6 + 20 * x.nbytes  # the matrix P would have 125 times the record


def test_series_of_every_family_are_the_same_function() -> None:
    t, x = clock("odd"), noise(401)
    for fit, degree in (("lsq", 20), ("smooth", 40)):
        values = []
        for name in FAMILIES:
            operator = Operator(t, Plan(fit, name, degree, penalty=3.0))
            values.append(operator.at_samples(operator.fit(x), 2))
        for other in values[1:]:
            assert other == pytest.approx(values[0], abs=1e-9 * np.abs(values[0]).max())
    assert CHEBYSHEV is FAMILIES["chebyshev"] and LEGENDRE is FAMILIES["legendre"]
    assert isinstance(operator.layout, Layout)
