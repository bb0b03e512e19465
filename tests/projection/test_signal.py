"""`Projection`: what it says about itself, and whether that is true."""

from dataclasses import replace

import numpy as np
import pytest
from bench.signals import COARSE, FINE, MOTIONS

from chebid.projection import Plan, Setting, project
from chebid.projection.quality import TOLERATED_SHARE, end_length, energy_left_out, lag1_autocorrelation, noise_floor
from chebid.projection.threads import one_thread, single


def clock(rate: float, duration: float) -> np.ndarray:
    return np.arange(int(rate * duration) + 1) / rate


# --- noise


@pytest.mark.parametrize("fit", ["lsq", "smooth"])
@pytest.mark.parametrize("samples", [200, 2000, 20_000])
def test_noise_of_known_size(fit: str, samples: int) -> None:
    """Within three of its own standard deviations, 1 / sqrt(2 N); quantisation adds count^2 / 12."""
    t = np.arange(samples) / 100
    for seed, count in ((0, 0.0), (1, 3e-3)):
        x = np.sin(3 * t) + 1e-3 * np.random.default_rng(seed).standard_normal(samples)
        x = np.round(x / count) * count if count else x
        p = project(t, x, Setting(fit, bandwidth=2.0))
        expected = np.hypot(1e-3, count / np.sqrt(12))
        assert p.noise == pytest.approx(expected, rel=3 / np.sqrt(2 * samples) + 0.01)


def test_noise_counts_the_degrees_of_freedom() -> None:
    t, x = clock(100, 1), np.random.default_rng(0).standard_normal(101)
    loose = project(t, x, Plan("smooth", degree=80, penalty=20.0))
    assert loose.operator.freedom > 0.3
    assert np.std(loose.residual) < 0.85
    assert loose.noise == pytest.approx(1, rel=0.2)


# --- energy left out


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("encoder", [FINE, COARSE], ids=["16 bit", "13 bit + noise"])
def test_a_bandwidth_too_low_is_told_and_a_sufficient_one_is_not(name: str, encoder) -> None:
    t = clock(100, 10)
    q, _, _ = MOTIONS[name](3, 10)(t)
    x = encoder.measure(q, 3)
    low = project(t, x, Setting(bandwidth=1.0))
    assert low.energy_left_out > 0.1
    assert [n.kind for n in low.notices()] == ["wide_band", "ends"] or low.notices()[0].kind == "wide_band"
    assert low.notices()[0].place.column == "x"
    assert "raise the bandwidth" in low.notices()[0].message
    enough = project(t, x, Setting(fit="smooth", bandwidth=25.0))
    assert enough.energy_left_out < TOLERATED_SHARE


def test_share_left_out_of_two_sines() -> None:
    """Accelerations a^2 w^4 / 2 of 1 Hz and of 5 Hz, cut between them."""
    t = clock(200, 20)
    for amplitude in (0.02, 0.2, 1.0):
        x = np.sin(2 * np.pi * t) + amplitude * np.sin(2 * np.pi * 5 * t)
        p = project(t, x + 1e-5 * np.random.default_rng(0).standard_normal(len(t)), Setting(bandwidth=2.5))
        share = amplitude**2 * 5**4 / (1 + amplitude**2 * 5**4)
        assert p.energy_left_out == pytest.approx(share, rel=0.1)


def test_noise_is_not_taken_for_motion() -> None:
    t = clock(100, 10)
    for seed in range(40):
        random = np.random.default_rng(seed)
        p = project(t, np.sin(t) + 0.01 * random.standard_normal(len(t)), Setting(bandwidth=1.0))
        assert p.energy_left_out == 0


def test_energy_left_out_has_no_unit() -> None:
    t = clock(100, 10)
    x = MOTIONS["multisine"](0, 10)(t)[0]
    one = project(t, x, Setting(bandwidth=1.0)).energy_left_out
    for gain, unit in ((1e-180, 1.0), (1e9, 1.0), (1.0, 1e-4)):
        assert project(t * unit, gain * x, Setting(bandwidth=1.0 / unit)).energy_left_out == pytest.approx(one)


def test_degenerate_spectra() -> None:
    t = clock(100, 1)
    zero = np.zeros(101)
    assert energy_left_out(t, zero, zero, 10.0, 0.0) == 0
    assert energy_left_out(t[:6], zero[:6], zero[:6], 10.0, 0.0) == 0
    assert noise_floor(np.ones(50), 100.0) < 1e-14


# --- ends


def test_ends_of_least_squares() -> None:
    """Beyond twice the median in the outer 17 % for accelerations, 11 % for velocities; less for the penalised fit."""
    t = clock(100, 10)
    x = np.sin(3 * t)
    plain = project(t, x, Setting(degree=50))
    assert plain.end_length(2) == pytest.approx(1.2, abs=0.2)  # the median is above the middle: 12 %
    assert plain.end_length(1) < plain.end_length(2)
    assert [n.kind for n in plain.notices()] == ["ends"]
    assert "s of the ends" in plain.notices()[0].message
    smooth = project(t, x, Setting("smooth", bandwidth=plain.plan.bandwidth))
    assert smooth.end_length(2) < 0.25 * plain.end_length(2)
    assert smooth.notices() == []


@pytest.mark.parametrize("order", [0, 1, 2])
def test_valid_samples_lie_between_the_ends(order: int) -> None:
    t = clock(100, 10)
    p = project(t, np.sin(3 * t), Setting(degree=50))
    valid, cut = p.valid(order), p.end_length(order)
    assert valid.dtype == bool and valid.shape == t.shape
    first, last = t[valid][0], t[valid][-1]
    assert max(first - t[0], t[-1] - last) == pytest.approx(cut)
    assert np.all(valid[np.argmax(valid) : len(t) - np.argmax(valid[::-1])])


def test_noise_really_is_higher_at_the_ends() -> None:
    t = clock(100, 10)
    plan = Plan("lsq", degree=50)
    random = np.random.default_rng(0)
    rows = np.array([project(t, random.standard_normal(1001), plan).at(t, 2) for _ in range(200)])
    spread, valid = rows.std(axis=0), project(t, np.sin(t), plan).valid(2)
    assert spread[valid].max() < 2.5 * np.median(spread)
    assert spread[~valid].min() > 1.6 * np.median(spread)


def test_costly_noise_profiles_follow_their_law(monkeypatch: pytest.MonkeyPatch) -> None:
    t = clock(100, 10)
    operator = project(t, np.sin(t), Setting(degree=50)).operator
    exact = end_length(operator, 2)
    monkeypatch.setattr("chebid.projection.quality._DENSE_WORK", 0)
    assert end_length(operator, 2) == pytest.approx(exact, abs=0.1)


def test_derivatives_that_are_zero_have_no_ends() -> None:
    t = clock(100, 1)
    assert project(t, t, Setting(degree=1)).end_length(2) == 0


# --- residual


def test_white_residuals_and_others() -> None:
    random = np.random.default_rng(0)
    white = random.standard_normal(10_000)
    assert lag1_autocorrelation(white) == pytest.approx(0, abs=0.03)
    assert lag1_autocorrelation(white[1:] + white[:-1]) == pytest.approx(0.5, abs=0.03)
    assert lag1_autocorrelation(np.zeros(9)) == 0
    t = clock(100, 20)
    x = MOTIONS["multisine"](0, 20)(t)[0] + 1e-4 * random.standard_normal(2001)
    assert abs(project(t, x, Setting()).lag1_autocorrelation) < 0.1
    assert project(t, x, Setting(bandwidth=1.0)).lag1_autocorrelation > 0.8


# --- evaluation


def test_at_other_instants_and_between() -> None:
    t = clock(100, 10)
    x, plan = np.sin(3 * t), Plan("smooth", degree=60, window=4.0, penalty=10.0)
    p = project(t, x, plan)
    assert p.plan is plan
    between = t[100:-101] + 0.005
    assert p.at(between, 1) == pytest.approx(3 * np.cos(3 * between), abs=1e-4)
    assert p.at(t.copy(), 1) == pytest.approx(p.at(t, 1), abs=1e-12)
    assert p.at(t)[0] + p.residual[0] == pytest.approx(x[0], abs=1e-15)


def test_plans_already_made_are_carried_out() -> None:
    t = clock(100, 10)
    x = np.sin(3 * t) + 1e-3 * np.random.default_rng(0).standard_normal(1001)
    first = project(t, x, Setting())
    again = project(t, x, replace(first.plan, reason="as before"))
    assert np.array_equal(first.at(t, 2), again.at(t, 2))


# --- threads


def test_one_thread_and_back() -> None:
    from threadpoolctl import threadpool_info, threadpool_limits

    def threads() -> set[int]:
        return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}

    before = threads()
    with one_thread():
        pass
    assert threads() == before
    assert single(lambda a, b=1: a + b)(1, b=2) == 3
    with threadpool_limits(1, "blas"):
        assert threads() == {1}


# --- at half the rate


@pytest.mark.parametrize(
    ("motion", "fast"),
    [
        ("multisine", False),  # without noise everything may pass, and nothing is up there
        ("quintic", False),
        ("bang_bang", True),  # accelerations that jump have energy at any frequency
        ("sine", True),  # 30 Hz in a log of 100 Hz
    ],
)
def test_a_bandwidth_next_to_half_the_rate_is_told_where_accelerations_are_there(motion: str, fast: bool) -> None:
    t = clock(100, 20)
    x = np.sin(2 * np.pi * 30 * t) if motion == "sine" else MOTIONS[motion](0, 20)(t)[0]
    p = project(t, x, Setting())
    told = [notice.message for notice in p.notices() if "half the rate" in notice.message]
    assert bool(told) == fast
    if fast:
        assert p.plan.bandwidth > 35
        assert f"bandwidth of {p.plan.bandwidth:.3g} Hz is next to half the rate of 100 Hz" in told[0]
    encoder = FINE.measure(MOTIONS["bang_bang"](0, 20)(t)[0], 0)
    assert project(t, encoder, Setting()).at_the_limit is False  # with counts the band is below
