"""The automatic choice: sound on every kind of record, true to the noise, and better than what is set by hand."""

import numpy as np
import pytest
from bench.signals import COARSE, FINE, MOTIONS, Encoder
from hypothesis import given
from hypothesis import strategies as st

from chebid.errors import NoAnswerError, UsageError
from chebid.projection import Plan, Projection, Setting, plan, project
from chebid.projection.choose import from_bandwidth
from chebid.projection.operator import Operator
from chebid.projection.sampled import Sampled
from chebid.projection.spectrum import Spectrum
from chebid.projection.stairs import samples_per_change
from chebid.projection.whittle import first_look

AUTO = Setting()


def clock(rate: float, duration: float) -> np.ndarray:
    return np.arange(int(rate * duration) + 1) / rate


def noisy_sine(t: np.ndarray, sigma: float = 1e-4, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """A sine of 1 Hz with noise, and its acceleration."""
    x = np.sin(2 * np.pi * t)
    return x + sigma * np.random.default_rng(seed).standard_normal(len(t)), -((2 * np.pi) ** 2) * x


def relative(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2)))


# --- the motions of the benchmark


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("rate", [100, 1000])
@pytest.mark.parametrize("encoder", [FINE, COARSE], ids=["16 bit", "13 bit + noise"])
def test_noise_level_and_no_false_warnings(name: str, rate: int, encoder: Encoder) -> None:
    t = clock(rate, 10)
    for seed in range(2):
        q, _, ddq = MOTIONS[name](seed, 10)(t)
        p = project(t, encoder.measure(q, seed), AUTO)
        # the error of an encoder without noise is not white when the motion rests, or takes few counts per sample
        white = encoder is COARSE
        assert p.noise == pytest.approx(encoder.noise, rel=0.06 if white else 0.2)
        assert p.notices() == []
        assert p.energy_left_out < 1e-4
        assert p.end_length() < 0.4
        assert relative(p.at(t, 2), ddq) < {"multisine": 0.01, "chirp": 0.01, "quintic": 0.06}.get(name, 0.25)


@pytest.mark.parametrize(
    ("name", "slopes"), [("multisine", {4, 16}), ("chirp", {4, 16}), ("quintic", {2}), ("bang_bang", {1})]
)
def test_shape_of_the_spectrum(name: str, slopes: set[int]) -> None:
    """Jumps of the acceleration fall with f^-1, of the jerk with f^-2, sines end at once."""
    t = clock(250, 20)
    for seed in range(3):
        assert plan(t, COARSE.measure(MOTIONS[name](seed, 20)(t)[0], seed), AUTO).slope in slopes


@pytest.mark.parametrize("name", ["multisine", "quintic", "bang_bang"])
def test_near_the_best_half_gain_frequency(name: str) -> None:
    """Little worse than the best of all half-gain frequencies, found with the truth; sharp spectra are harder."""
    t = clock(200, 15)
    q, _, ddq = MOTIONS[name](1, 15)(t)
    x = COARSE.measure(q, 1)
    p = project(t, x, AUTO)
    from dataclasses import replace

    tried = [project(t, x, replace(p.plan, penalty=p.plan.penalty * k)) for k in np.geomspace(0.5, 1.5, 12)]
    inner = slice(150, -150)
    best = min(relative(other.at(t, 2)[inner], ddq[inner]) for other in tried)
    assert relative(p.at(t, 2)[inner], ddq[inner]) < (1.35 if name == "multisine" else 1.1) * best


def test_the_choice_scales_with_units_and_turns_with_time() -> None:
    t = clock(100, 10)
    x = COARSE.measure(MOTIONS["quintic"](0, 10)(t)[0], 0)
    one = plan(t, x, AUTO)
    for unit, gain, offset in ((1e-3, 1.0, 0.0), (1.0, 1e-9, 0.0), (1e6, 1e6, 3e5), (1.0, -1.0, 1.0)):
        other = plan(t * unit, gain * x + offset, AUTO)
        assert other.penalty * unit == pytest.approx(one.penalty, rel=1e-6)
        assert other.band * unit == pytest.approx(one.band, rel=1e-6)
        assert (other.degree, other.slope) == (one.degree, one.slope)
    assert plan(t, x[::-1].copy(), AUTO).penalty == pytest.approx(one.penalty, rel=0.15)


# --- records of every kind


@pytest.mark.parametrize("samples", [24, 25, 30, 50, 101])
@pytest.mark.parametrize("fit", [None, "lsq", "quadrature"])
def test_short_records(samples: int, fit: str | None) -> None:
    t = np.arange(samples) / 100
    x, acceleration = noisy_sine(t, 1e-6)
    p = project(t, x, Setting(fit))
    assert np.all(np.isfinite(p.at(t, 2)))
    inner = slice(samples // 4, -samples // 4)
    assert relative(p.at(t, 2)[inner], acceleration[inner]) < 0.15


@pytest.mark.parametrize("samples", [1, 4, 5, 23])
def test_too_short_records(samples: int) -> None:
    t = np.arange(samples) / 100
    with pytest.raises(NoAnswerError, match=r"too short|usable samples") as caught:
        project(t, np.sin(t), AUTO)
    assert caught.value.hint


@pytest.mark.parametrize("fit", [None, "lsq", "quadrature"])
@pytest.mark.parametrize("value", [0.0, 2.5, -1e9, 1e-300])
def test_constants(fit: str | None, value: float) -> None:
    t = clock(100, 10)
    p = project(t, np.full(1001, value), Setting(fit))
    assert p.at(t) == pytest.approx(np.full(1001, value), rel=1e-14)
    assert p.at(t, 2) == pytest.approx(np.zeros(1001), abs=1e-12 * abs(value))
    assert p.energy_left_out == 0
    assert p.noise <= 1e-14 * abs(value)


@pytest.mark.parametrize("degree", [1, 2, 3, 5, 9])
@pytest.mark.parametrize("fit", [None, "lsq"])
def test_polynomials_without_noise(degree: int, fit: str | None) -> None:
    """Nothing but rounding is left, which degenerate weights must survive."""
    t = clock(100, 10)
    exact = np.polynomial.Polynomial(np.random.default_rng(degree).standard_normal(degree + 1), domain=[0, 10])
    p = project(t, exact(t), Setting(fit))
    assert p.at(t) == pytest.approx(exact(t), abs=1e-9)
    assert p.at(t, 2) == pytest.approx(exact.deriv(2)(t), abs=1e-3)  # rounding, times the noise gain at the ends
    assert p.at(t, 2)[100:-100] == pytest.approx(exact.deriv(2)(t)[100:-100], abs=1e-8)
    assert not [n for n in p.notices() if n.kind == "wide_band"]


def test_pure_noise() -> None:
    t = clock(100, 10)
    p = project(t, np.random.default_rng(0).standard_normal(1001), AUTO)
    assert p.noise == pytest.approx(1, rel=0.05)
    assert np.abs(p.at(t)).max() < 0.5
    assert p.plan.penalty < 0.5


@pytest.mark.parametrize(("gain", "offset"), [(1e-9, 0.0), (1e-200, 0.0), (1e150, 0.0), (1e-3, 1e5), (1.0, -3e6)])
def test_any_unit_and_offset(gain: float, offset: float) -> None:
    t = clock(100, 10)
    x, acceleration = noisy_sine(t, 1e-4)
    p = project(t, gain * x + offset, AUTO)
    rounding = np.finfo(float).eps * abs(offset) / gain
    assert p.noise / gain == pytest.approx(1e-4, rel=0.05, abs=rounding)
    assert p.at(t, 2)[100:-100] / gain == pytest.approx(acceleration[100:-100], abs=0.03)
    assert 0 <= p.energy_left_out < 1e-4
    assert abs(p.lag1_autocorrelation) < 0.15


@pytest.mark.parametrize("rate", [10, 30, 300, 3000, 10_000])
def test_any_rate(rate: int) -> None:
    t = clock(rate, 20)
    x, acceleration = noisy_sine(t, 1e-4)
    p = project(t, x, AUTO)
    assert p.noise == pytest.approx(1e-4, rel=0.1 if rate < 30 else 0.04)
    assert relative(p.at(t, 2), acceleration) < 3e-3
    assert p.notices() == []


@pytest.mark.parametrize("rate", [100, 1000, 10_000])
@pytest.mark.parametrize("count", [1e-2, 1e-3, 1e-4])
def test_stairs_of_a_coarse_encoder_are_no_motion(rate: int, count: float) -> None:
    """A slow motion of a few counts, then a rest: between changes the error of the encoder is not white at all."""
    t = clock(rate, 10)
    envelope = np.sin(np.clip(t - 3, 0, 5) * np.pi / 10) ** 4
    motion = 0.05 * np.sin(t) * envelope
    acceleration = np.gradient(np.gradient(motion, t), t)
    p = project(t, np.round(motion / count) * count, AUTO)
    error = np.abs(p.at(t, 2) - acceleration)[rate:-rate].max()
    assert error < {1e-2: 0.03, 1e-3: 0.013, 1e-4: 0.012}[count]  # of 0.08; following the stairs gave up to 3000
    assert p.plan.penalty < 5
    assert p.noise == pytest.approx(count / np.sqrt(12), rel=0.4)  # at rest there is none
    assert p.notices() == []


def test_samples_per_change() -> None:
    assert samples_per_change(np.arange(100.0)) == 1
    assert samples_per_change(np.arange(100) // 7 * 1.0) == pytest.approx(7, rel=0.15)
    moving = np.concatenate([np.zeros(5000), np.arange(1000) // 5, np.full(4000, 199)])
    assert samples_per_change(moving) == pytest.approx(5, rel=0.1)  # rests do not count
    assert samples_per_change(np.zeros(10)) == 1


@pytest.mark.parametrize("count", [0.0, 1e-3])
def test_a_long_rest_then_a_motion(count: float) -> None:
    """What rests says nothing about what moves: the motion is one sixtieth of the record."""
    t = clock(100, 600)
    after = np.maximum(t - 590, 0)
    motion = np.sin(6 * after) * np.sin(np.clip(after, 0, 5) * np.pi / 10) ** 4
    acceleration = np.gradient(np.gradient(motion, t), t)
    x = np.round(motion / count) * count if count else motion + 1e-4 * np.random.default_rng(0).standard_normal(len(t))
    p = project(t, x, AUTO)
    moving = (t > 590.5) & (t < 599)
    assert relative(p.at(t, 2)[moving], acceleration[moving]) < 0.01
    assert p.notices() == []


@pytest.mark.parametrize("kind", ["step", "spike", "square", "random walk"])
def test_what_is_no_motion_still_has_an_answer(kind: str) -> None:
    t = clock(100, 20)
    x = {
        "step": np.where(t > 5, 1.0, 0.0), "spike": np.where(t == 5, 1.0, 0.0), "square": np.sign(np.sin(6 * t)),
        "random walk": np.cumsum(np.random.default_rng(0).standard_normal(len(t))),
    }[kind]  # fmt: skip
    for fit in (None, "lsq", "quadrature"):
        p = project(t, x, Setting(fit))
        assert np.all(np.isfinite(p.at(t, 2)))
        p.notices()


# --- uneven stamps, gaps, missing samples


@pytest.mark.parametrize("kind", ["jitter", "random", "growing", "gap", "dropouts"])
def test_uneven_stamps(kind: str) -> None:
    random = np.random.default_rng(1)
    t = {
        "jitter": (np.arange(2001) + 0.45 * random.uniform(-1, 1, 2001)) / 200,
        "random": np.sort(random.uniform(0, 10, 2000)),
        "growing": 10 * np.linspace(0, 1, 2001) ** 2,
        "gap": np.concatenate([np.arange(1000), np.arange(1400, 2000)]) / 200,
        "dropouts": np.sort(random.choice(2000, 1500, replace=False)) / 200,
    }[kind]
    x, acceleration = noisy_sine(t, 1e-4)
    p = project(t, x, AUTO)
    assert p.noise == pytest.approx(1e-4, rel=0.05)
    assert relative(p.at(t, 2), acceleration) < 3e-3  # also on both sides of the gap
    assert p.plan.penalty < 4


def test_missing_samples_are_left_out() -> None:
    t = clock(100, 10)
    x, acceleration = noisy_sine(t)
    gone = np.zeros(len(t), dtype=bool)
    gone[300:340] = True
    gone[np.random.default_rng(0).choice(1001, 80, replace=False)] = True
    p = project(t, np.where(gone, np.nan, x), AUTO)
    assert np.array_equal(p.t, t[~gone])
    same = project(t[~gone], x[~gone], AUTO)
    assert same.plan == p.plan
    assert np.array_equal(same.at(t, 1), p.at(t, 1))
    assert relative(p.at(t, 2), acceleration) < 3e-3  # in the hole of 0.4 s as well
    infinite = np.where(gone, np.inf, x)
    assert np.array_equal(project(t, infinite, AUTO).at(t), p.at(t))


def test_mostly_missing() -> None:
    x = np.full(500, np.nan)
    x[:3] = 1
    with pytest.raises(NoAnswerError, match="only 3 usable samples") as caught:
        project(clock(100, 4.99), x, AUTO, "q2")
    assert caught.value.place.column == "q2"


# --- long records


def test_long_records_have_windows_and_the_quality_of_short_ones() -> None:
    errors = []
    for duration in (10, 120):
        t = clock(100, duration)
        q, _, ddq = MOTIONS["multisine"](0, duration)(t)
        p = project(t, COARSE.measure(q, 0), AUTO)
        errors.append(relative(p.at(t, 2)[100:-100], ddq[100:-100]))
    assert p.operator.layout.count > 5
    assert errors[1] < 2 * errors[0]


def test_a_million_samples_do_not_get_windows_without_end() -> None:
    t = clock(1000, 1000)
    x, acceleration = noisy_sine(t, 1e-4)
    p = project(t, x, AUTO)
    assert p.operator.layout.count < 400
    assert relative(p.at(t, 2), acceleration) < 1e-3


# --- what is set


def test_settings_that_do_not_fit_together() -> None:
    t = clock(100, 1)
    with pytest.raises(UsageError, match="both a degree and a bandwidth"):
        plan(t, t, Setting(degree=5, bandwidth=2.0))
    with pytest.raises(UsageError, match="degree 0 is below 1"):
        plan(t, t, Setting(degree=0))
    with pytest.raises(NoAnswerError, match="degree 50 is too high for 101 samples"):
        project(t, t, Setting(degree=50))
    with pytest.raises(NoAnswerError, match="degree 200 is too high for 101 samples"):
        plan(t, t, Setting("smooth", degree=200))


def test_a_degree_is_kept() -> None:
    t = clock(100, 10)
    x, acceleration = noisy_sine(t)
    plain = plan(t, x, Setting(degree=60))
    assert plain == Plan("lsq", "chebyshev", 60, None, np.inf, 60 / (10 * np.pi), "degree as set")
    for degree in (60, 125, 500):
        p = project(t, x, Setting("smooth", degree=degree))
        assert p.plan.degree == degree
        assert p.plan.reason.startswith("degree as set")
        assert relative(p.at(t, 2), acceleration) < 0.01
    low = project(t, x, Setting("smooth", degree=2))
    assert np.all(np.isfinite(low.at(t, 2)))


@pytest.mark.parametrize("fit", ["lsq", "quadrature", "smooth"])
def test_a_bandwidth_is_passed_everywhere(fit: str) -> None:
    for samples in (2001, 60_001):
        t = np.arange(samples) / 100
        x = np.sin(2 * np.pi * 2.5 * t)
        p = project(t, x, Setting(fit, bandwidth=4.0))
        inner = slice(300, -300)
        assert p.at(t)[inner] == pytest.approx(x[inner], abs=0.03 if fit != "lsq" else 1e-5)
        assert p.plan.bandwidth == pytest.approx(4.0, rel=0.02)


def test_without_a_penalty_the_cut_is_where_signal_and_noise_are_equal() -> None:
    t = clock(100, 10)
    x = COARSE.measure(MOTIONS["multisine"](0, 10)(t)[0], 0)
    smooth, plain = plan(t, x, AUTO), plan(t, x, Setting("lsq"))
    assert plain == from_bandwidth(t, smooth.penalty)


def test_reasons_are_given() -> None:
    t = clock(100, 10)
    x = COARSE.measure(MOTIONS["bang_bang"](0, 10)(t)[0], 0)
    assert "restricted maximum likelihood" in plan(t, x, AUTO).reason
    assert "degree = pi 2 Hz T" in from_bandwidth(t, 2.0).reason
    assert "windows of" in from_bandwidth(t, 9.0).reason
    assert "-3 dB at 9 Hz" in from_bandwidth(t, 9.0, "smooth").reason


# --- the first look


def test_first_look_finds_the_spectrum_it_was_made_from() -> None:
    """Twice integrated band-limited noise in white noise."""
    random = np.random.default_rng(0)
    f = np.fft.rfftfreq(1 << 15, 0.01)
    shape = np.zeros(len(f))
    shape[1:] = 1 / np.sqrt(1 + (f[1:] / 1.5) ** 4) / (2 * np.pi * f[1:]) ** 2
    x = np.fft.irfft(shape * np.exp(2j * np.pi * random.uniform(size=len(f)))) * 3e4
    noise = x.std() * 1e-4
    sampled = Sampled.of(np.arange(len(x)) / 100, x + noise * random.standard_normal(len(x)))
    found, half = first_look(sampled.segments(), sampled.rate)
    assert found.slope == 2
    assert found.band == pytest.approx(1.5, rel=0.3)
    # where the spectrum of the motion has fallen to that of the noise
    power = 3e4**2 * shape**2 * 2 / len(f)
    assert half == pytest.approx(f[1:][np.argmin(np.abs(power[1:] - noise**2))], rel=0.2)


def test_stretches_at_rest_are_not_looked_at() -> None:
    t = clock(100, 100)
    x = np.where((t > 40) & (t < 50), np.sin(6 * t), 0.0)
    tiles = Sampled.of(t, x).tiles(6, 64)
    assert 1 <= len(tiles.x) <= 12
    assert isinstance(Spectrum(1, 2.0).scaled(2.0), Spectrum)
    assert isinstance(project(t, x, AUTO), Projection)


@given(span=st.floats(4, 60), rate=st.sampled_from([100.0, 200.0, 1000.0]), share=st.floats(0.005, 0.35))
def test_a_plan_for_a_bandwidth_fits_its_windows(span, rate, share):
    """Found by the blind study: 33 s at 100 Hz, windows of 71 samples, and a degree for 72."""
    t = np.arange(int(span * rate)) / rate
    for fit in ("smooth", "lsq"):
        plan = from_bandwidth(t, share * rate, fit)
        Operator(t, plan)  # refuses a degree that is too high


@pytest.mark.parametrize("fit", ["smooth", "lsq"])
@pytest.mark.parametrize(("rate", "gap", "count"), [(200, 86, 5329), (1000, 800, 20000), (100, 100, 2000)])
def test_a_gap_as_long_as_a_window_disturbs_nothing_far_away(rate, gap, count, fit):
    """Found by a probe: a joint whose encoder stood still for 0.43 s, windows of 0.35 s, and no sample in one."""
    t = np.delete(np.arange(count) / rate, slice(count // 2, count // 2 + gap))
    for bandwidth in (5.0, 0.2 * rate, 0.33 * rate):
        plan = from_bandwidth(t, bandwidth, fit)
        found = project(t, np.sin(2 * np.pi * 0.5 * t), plan)
        away = (
            (np.abs(t - (count + gap) / 2 / rate) > gap / rate + 2 * (plan.window or 0.0)) & (t > 1) & (t < t[-1] - 1)
        )
        np.testing.assert_allclose(found.at(t)[away], np.sin(2 * np.pi * 0.5 * t)[away], atol=1e-4)
