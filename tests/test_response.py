"""The frequency response against closed forms, against slow twins, and against what must hold for any such operator."""

import json
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import scipy.special
from hypothesis import given
from hypothesis import strategies as st

from chebid.basis import FAMILIES, LEGENDRE
from chebid.cli import main
from chebid.errors import NoAnswerError, UsageError
from chebid.projection import Operator, Plan, from_bandwidth, plan
from chebid.projection.choose import Setting
from chebid.response import (
    THREE_DB,
    Wish,
    clock,
    closed_form,
    cutoff,
    decibel,
    linear_interpolation,
    plan_for,
    response,
    sweep,
)

# (n, f T): 20 log10 of the gain for the Chebyshev weight and for least squares, on a continuous record
REFERENCE = {
    (10, 4): (-3.80883, -4.50105),
    (20, 8): (-4.82534, -7.98213),
    (30, 10): (-0.90979, -1.05353),
    (40, 16): (-4.55687, -7.32374),
    (60, 20): (-1.26579, -1.64096),
    (100, 40): (-4.66958, -7.91759),
    (125, 30): (0.0, 0.0),
    (125, 40): (-0.31881, -0.40235),
    (125, 50): (-4.61462, -7.83698),
}
ALL_PLANS = [
    Wish(degree=60),
    Wish(degree=60, basis="chebyshev2"),
    Wish(degree=60, basis="legendre"),
    Wish(degree=60, fit="quadrature"),
    Wish(degree=60, fit="quadrature", basis="chebyshev2"),
    Wish(degree=60, fit="quadrature", basis="legendre"),
    Wish(degree=60, fit="smooth"),
    Wish(bandwidth=4.0),
    Wish(bandwidth=4.0, fit="quadrature"),
    Wish(bandwidth=4.0, fit="smooth"),
    Wish(degree=20, window=2.0),
    Wish(degree=40, window=3.0, fit="smooth", penalty=5.0),
]


def operator(wish: Wish, rate: float = 100.0, duration: float = 10.0) -> Operator:
    t = clock(rate, duration)
    return Operator(t, plan_for(t, wish))


# --- closed forms


@pytest.mark.parametrize(("n", "cycles"), REFERENCE)
def test_closed_forms_have_the_reference_values(n: int, cycles: float) -> None:
    found = [float(decibel(closed_form(weight, n, np.pi * cycles))) for weight in ("chebyshev", "legendre")]
    assert found == pytest.approx(REFERENCE[n, cycles], abs=6e-6)  # five decimals are given


@pytest.mark.parametrize("name", FAMILIES)
@pytest.mark.parametrize("n", [0, 1, 7, 20])
def test_closed_forms_are_the_weighted_projection_of_a_sine(name: str, n: int) -> None:
    family, w = FAMILIES[name], 11.0

    def product(f, g):
        return family.inner(f, lambda tau: g(tau).real) + 1j * family.inner(f, lambda tau: g(tau).imag)

    def polynomial(k):
        return lambda tau: family.values(tau, n)[:, k]

    parts = [abs(product(polynomial(k), lambda tau: np.exp(1j * w * tau))) ** 2 for k in range(n + 1)]
    unit = family.inner(np.ones_like, np.ones_like)
    gain = sum(parts / family.norms(np.arange(n + 1.0))) / unit
    assert closed_form(name, n, w) == pytest.approx(gain, abs=1e-11)  # the weight at the outermost nodes of `inner`


@pytest.mark.parametrize("weight", FAMILIES)
def test_closed_forms_at_zero_frequency_and_at_many_at_once(weight: str) -> None:
    w = np.array([[0.0, 1.0], [5.0, 50.0]])
    together = closed_form(weight, 12, w)
    assert together.shape == w.shape
    assert together[0, 0] == 1
    assert together == pytest.approx(np.vectorize(lambda one: float(closed_form(weight, 12, one)))(w), rel=1e-14)


@pytest.mark.parametrize(("error", "factor"), [(1e-3, 1.3), (1e-6, 2.8), (1e-9, 4.1), (1e-12, 5.1)])
@pytest.mark.parametrize("w", [20.0, 100.0, 400.0])
def test_degrees_that_resolve_a_sine(w: float, error: float, factor: float) -> None:
    n = int(np.ceil(w + factor * w ** (1 / 3)))
    assert 1 - closed_form("chebyshev", n, w) < error + 1e-13
    assert 1 - closed_form("chebyshev", int(w - 3 * w ** (1 / 3)), w) > 1e-2  # and far fewer do not


def test_closed_form_of_an_unknown_weight() -> None:
    with pytest.raises(UsageError, match="no closed form for the weight 'hermite'"):
        closed_form("hermite", 3, 1.0)


# --- the discrete operator against the closed forms


@pytest.mark.parametrize(("n", "cycles"), [key for key in REFERENCE if key[0] <= 4 * np.sqrt(15 * key[1] + 1)])
def test_least_squares_at_15_points_per_period(n: int, cycles: float) -> None:
    found = response(Operator(clock(15 * cycles, 1.0), Plan(degree=n)), cycles)
    assert found.gain_db_whole[0] == pytest.approx(REFERENCE[n, cycles][1], abs=0.42)  # 0.02 to 0.4 dB: facts
    assert found.gain_db_whole[0] != pytest.approx(REFERENCE[n, cycles][1], abs=0.01)


@pytest.mark.parametrize("cycles", [4, 8, 10])
def test_least_squares_tends_to_the_closed_form_with_more_points(cycles: int) -> None:
    n = 3 * cycles
    exact = decibel(closed_form("legendre", n, np.pi * cycles))
    errors = []
    for points in (50, 500):
        found = response(Operator(clock(points * cycles, 1.0), Plan(degree=n)), cycles)
        errors.append(abs(found.gain_db_whole[0] - exact))
    assert errors[1] < 0.2 * errors[0] < 0.05  # first order in the step: the ends of the sum


def test_quadrature_is_lower_by_the_straight_lines_between_samples() -> None:
    """At 15 points per period sinc^2 costs 0.127 dB in the coefficients, at every degree."""
    assert decibel(linear_interpolation(1, 15)) == pytest.approx(-0.127, abs=5e-4)
    cycles, n = 30, 80
    t = clock(15 * cycles, 1.0)
    w, tau = np.pi * cycles, 2 * t - 1
    made = Operator(t, Plan("quadrature", degree=n))
    series = made.fit(np.column_stack([np.cos(w * tau), np.sin(w * tau)]))
    got = series.coefficients[0] @ np.array([1, 1j])
    k = np.arange(n + 1)
    exact = np.where(k == 0, 1, 2) * 1j**k * scipy.special.jv(k, w)
    inner = np.sum(np.conj(exact) * got * np.where(k == 0, 1, 0.5))
    expected = decibel(closed_form("chebyshev", n, w)) + decibel(linear_interpolation(cycles, 15 * cycles))
    assert decibel(inner) == pytest.approx(expected, abs=0.005)  # aliases of the interpolation: 1e-3 of the sine


def continuous_gain(n: int, w: float, order: int, inner: float) -> complex:
    """Complex fit over |tau| < inner of the least-squares projection of exp(i w tau) on a continuous record."""
    k = np.arange(n + 1)
    c = (2 * k + 1) * 1j**k * scipy.special.spherical_jn(k, w)
    x, weight = np.polynomial.legendre.leggauss(400)
    x = inner * x
    output = LEGENDRE.evaluate(x, LEGENDRE.differentiate(c.real, order))
    output = output + 1j * LEGENDRE.evaluate(x, LEGENDRE.differentiate(c.imag, order))
    return complex(np.sum(weight * output / ((1j * w) ** order * np.exp(1j * w * x))) / 2)


def boundary_form(n: int, w: float) -> float:
    """Order 1 over the whole record in closed form: order 0, and what integrating by parts leaves at the two ends."""
    k = np.arange(n + 1)
    j = (2 * k + 1) * scipy.special.spherical_jn(k, w)
    signs = np.where(k % 2 == 0, -((-1.0) ** (k // 2)) * np.sin(w), (-1.0) ** ((k - 1) // 2) * np.cos(w))
    return float(closed_form("legendre", n, w) + np.sum(j * signs) / w)


@pytest.mark.parametrize(("n", "cycles"), [(12, 2.3), (20, 5.7), (30, 10.0), (31, 11.2)])
def test_first_derivative_over_the_whole_record_has_a_closed_form(n: int, cycles: float) -> None:
    w = np.pi * cycles
    assert continuous_gain(n, w, 1, 1.0) == pytest.approx(boundary_form(n, w), abs=1e-11)
    found = response(Operator(clock(2e4, 1.0), Plan(degree=n)), cycles, 1)
    # the sum over samples differs from the integral by half a step at each end, times the misfit there
    assert abs(found.whole[0] - boundary_form(n, w)) < 1e-4 * n


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize(("n", "cycles"), [(12, 2.3), (20, 5.7), (30, 9.0), (30, 10.3)])
def test_interior_gain_of_derivatives_on_a_continuous_record(n: int, cycles: float, order: int) -> None:
    found = response(Operator(clock(2e4, 1.0), Plan(degree=n)), cycles, order)
    assert abs(found.inner[0] - continuous_gain(n, np.pi * cycles, order, 0.9)) < 3e-4 * (1 + n * order / 10)  # idem


# --- slow twin


def naive_response(t: np.ndarray, n: int, f: float, order: int, inner: float) -> complex:
    """Fit by numpy, differentiate by numpy, and fit the complex amplitude by least squares, one frequency at a time."""
    tau = 2 * (t - t[0]) / (t[-1] - t[0]) - 1
    chebyshev = np.polynomial.chebyshev
    output = [chebyshev.chebfit(tau, wave(2 * np.pi * f * t), n) for wave in (np.cos, np.sin)]
    scale = (2 / (t[-1] - t[0])) ** order
    real, imaginary = (scale * chebyshev.chebval(tau, chebyshev.chebder(c, order)) for c in output)
    ideal = (2j * np.pi * f) ** order * np.exp(2j * np.pi * f * t)
    where = np.abs(tau) < inner * (1 - 1e-9)
    # unknowns a, b of (a + i b): real and imaginary parts are separate equations
    z, y = ideal[where], (real + 1j * imaginary)[where]
    matrix = np.block([[z.real[:, None], -z.imag[:, None]], [z.imag[:, None], z.real[:, None]]])
    (a, b), *_ = np.linalg.lstsq(matrix, np.concatenate([y.real, y.imag]), rcond=None)
    return complex(a, b)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_same_as_the_slow_twin(order: int) -> None:
    t = 3.0 + clock(50.0, 4.0)  # a record need not start at 0
    f = [0.1, 1.0, 2.0, 2.5, 3.0, 7.0, 24.9]
    found = response(Operator(t, Plan(degree=30)), f, order)
    assert found.inner == pytest.approx([naive_response(t, 30, one, order, 0.9) for one in f], abs=1e-11)
    assert found.whole == pytest.approx([naive_response(t, 30, one, order, 2.0) for one in f], abs=1e-8)


def test_the_same_as_the_slow_twin_on_uneven_stamps() -> None:
    t = clock(50.0, 4.0) + 0.004 * np.sin(np.arange(201) ** 2)
    found = response(Operator(t, Plan(degree=20)), [1.0, 2.0], 1)
    assert found.inner == pytest.approx([naive_response(t, 20, one, 1, 0.9) for one in (1.0, 2.0)], abs=1e-11)


@pytest.mark.parametrize("wish", [wish for wish in ALL_PLANS if wish.window or wish.bandwidth], ids=str)
@pytest.mark.parametrize("order", [0, 1, 2])
def test_windows_are_those_of_the_operator(wish: Wish, order: int) -> None:
    """One shared window and the summed weights of the blend, against sines through the whole record."""
    made = operator(wish)
    assert made.layout.count > 1
    f = np.array([0.3, 2.0, 4.5, 6.0, 30.0])
    ideal = (2j * np.pi * f) ** order * np.exp(2j * np.pi * np.outer(made.t, f))
    sines = np.exp(2j * np.pi * np.outer(made.t, f))
    real, imaginary = (made.at_samples(made.fit(part), order) for part in (sines.real, sines.imag))
    relative = (real + 1j * imaginary) / ideal
    found = response(made, f, order)
    inner = np.abs(2 * made.t / made.t[-1] - 1) < 0.9 * (1 - 1e-9)
    assert found.inner == pytest.approx(relative[inner].mean(axis=0), abs=1e-11)
    assert found.whole == pytest.approx(relative.mean(axis=0), abs=1e-10)


def test_long_records_are_looked_at_here_and_there() -> None:
    """Beyond 20000 samples the output is taken at some of them: no difference that matters."""
    long = response(Operator(clock(5000.0, 10.0), Plan(degree=40)), [0.5, 1.3, 1.5], 2)
    short = response(Operator(clock(1500.0, 10.0), Plan(degree=40)), [0.5, 1.3, 1.5], 2)
    assert long.inner == pytest.approx(short.inner, abs=2e-3)


# --- what holds for every operator


@pytest.mark.parametrize("order", [0, 1, 2])
@pytest.mark.parametrize("wish", ALL_PLANS, ids=str)
def test_pass_band_phase_and_cutoff(wish: Wish, order: int) -> None:
    made = operator(wish)
    cut = cutoff(made, order)
    assert cut is not None
    assert abs(response(made, cut, order).inner[0]) == pytest.approx(THREE_DB, abs=1e-8)
    below = response(made, np.linspace(0.05, 0.8, 40) * cut, order)
    assert np.all(np.abs(below.inner) > THREE_DB)
    assert np.all(np.abs(below.inner) < 1.01)
    assert np.all(np.abs(below.phase_deg) < 0.2)  # the paper: the rebuilt derivative is in phase
    assert abs(below.gain_db[:10]).max() < 0.01
    above = response(made, np.linspace(1.3, 3.0, 10) * cut, order)
    assert np.all(np.abs(above.inner) < THREE_DB)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_penalty_acts_like_a_butterworth_filter_both_ways(order: int) -> None:
    made = operator(Wish(bandwidth=8.0, fit="smooth"))
    f = np.linspace(0.5, 11.5, 40)  # the degree resolves 13 Hz
    law = 1 / (1 + (f / made.plan.penalty) ** 8)
    assert response(made, f, order).inner == pytest.approx(law, abs=2e-5)  # what the ends leave of themselves
    assert cutoff(made, order) == pytest.approx(8.0, rel=1e-6)


def test_degree_limits_the_penalised_fit_too() -> None:
    """A loose penalty leaves the cut-off to the degree, a tight one to the penalty."""
    tight = cutoff(operator(Wish(degree=60, fit="smooth", penalty=1.0)))
    loose = cutoff(operator(Wish(degree=60, fit="smooth", penalty=20.0)))
    assert tight == pytest.approx((np.sqrt(2) - 1) ** 0.125, rel=0.01)
    assert loose == pytest.approx(cutoff(operator(Wish(degree=60))), rel=0.02)


fits = st.sampled_from(["lsq", "smooth"])


@given(fit=fits, degree=st.integers(4, 40), f=st.floats(0.01, 24.9), rate=st.floats(50, 200))
def test_least_squares_is_a_contraction_without_phase(fit: str, degree: int, f: float, rate: float) -> None:
    """H is symmetric with eigenvalues from 0 to 1, so that <x, H x> / <x, x> over all samples is such a number."""
    made = operator(Wish(degree=degree, fit=fit), rate, 4.0)
    whole = response(made, f).whole[0]
    assert -1e-12 < whole.real < 1 + 1e-12
    assert abs(whole.imag) < 1e-12
    assert abs(response(made, f).inner[0]) < 1.05


@given(
    degree=st.integers(6, 38), order=st.sampled_from([0, 1, 2]), fit=st.sampled_from(["lsq", "quadrature", "smooth"])
)
def test_a_higher_degree_has_a_higher_cutoff(degree: int, order: int, fit: str) -> None:
    low, high = (cutoff(operator(Wish(degree=n, fit=fit), 50.0, 4.0), order) for n in (degree, degree + 2))
    assert low is not None and high is not None
    assert low < high
    assert high == pytest.approx((degree + 2) / (4 * np.pi), rel=0.35)


@given(
    degree=st.integers(2, 30), f=st.floats(0.1, 20.0), scale=st.floats(0.01, 100.0), order=st.sampled_from([0, 1, 2])
)
def test_gains_do_not_depend_on_the_unit_of_time(degree: int, f: float, scale: float, order: int) -> None:
    a = response(Operator(np.arange(201) / 50, Plan(degree=degree)), f, order)
    b = response(Operator(np.arange(201) / 50 / scale, Plan(degree=degree)), f * scale, order)
    assert b.inner == pytest.approx(a.inner, abs=1e-9)


def test_batches_do_not_change_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    made, f = operator(Wish(degree=20)), np.linspace(0.1, 3, 17)
    together = response(made, f, 1)
    monkeypatch.setattr("chebid.response._BATCH", 5000)
    assert response(made, f, 1).inner == pytest.approx(together.inner, abs=1e-12)


# --- plans


def test_degree_and_bandwidth_make_the_plans_of_the_other_commands() -> None:
    t = clock(100, 10)
    x = np.sin(t)
    for wish in (Wish(degree=50), Wish(bandwidth=2.0), Wish(bandwidth=6.0), Wish(bandwidth=6.0, fit="smooth")):
        setting = Setting(wish.fit, wish.basis, wish.degree, wish.bandwidth)
        assert plan_for(t, wish) == plan(t, x, setting)


def test_bandwidth_gives_the_degree() -> None:
    found = sweep(100, 10, Wish(bandwidth=2.0))
    assert (found.plan.degree, found.windows) == (63, 1)  # pi 2 10
    assert found.cutoff == pytest.approx(2.1, abs=0.05)
    many = sweep(100, 10, Wish(bandwidth=4.0))  # 126 > 3 sqrt(1001)
    assert many.windows > 1
    assert many.plan == from_bandwidth(clock(100, 10), 4.0)
    assert "overlapping windows" in many.sentence()


def test_smooth_with_a_degree_gets_the_penalty_of_its_bandwidth() -> None:
    made = operator(Wish(degree=60, fit="smooth"))
    assert made.plan.penalty == pytest.approx(60 / (10 * np.pi) / (np.sqrt(2) - 1) ** 0.125)
    assert 0.95 < cutoff(made) / (60 / (10 * np.pi)) < 1  # the degree itself takes a little more
    assert operator(Wish(degree=60, fit="smooth", penalty=1.0)).plan.penalty == 1.0


def test_no_cutoff_below_half_the_rate() -> None:
    found = sweep(10, 0.5, Wish(degree=5))  # interpolates: everything passes
    assert found.cutoff is None
    assert found.document()["cutoff"] is None
    assert "no -3 dB point" in found.sentence()
    assert found.response.frequency[-1] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        (Wish(), "either a degree or a bandwidth"),
        (Wish(degree=5, bandwidth=1.0), "either a degree or a bandwidth"),
        (Wish(degree=0), "degree 0 is below 1"),
        (Wish(degree=3, fit="smooth"), "degree 3 is below 4"),
        (Wish(degree=5, penalty=3.0), "penalty does not go with fit lsq"),
        (Wish(degree=5, fit="smooth", penalty=-3.0), "penalty -3 Hz is not positive"),
        (Wish(degree=5, window=11.0), "window 11 s is not between 0 and the duration, 10 s"),
        (Wish(degree=5, window=0.0), "window 0 s is not between"),
        (Wish(bandwidth=1.0, window=2.0), "chooses its own window"),
        (Wish(bandwidth=50.0), "not between 0 and half the rate"),
        (Wish(degree=5, fit="exact"), "unknown fit 'exact'"),
        (Wish(degree=5, basis="hermite"), "unknown basis 'hermite'"),
    ],
    ids=str,
)
def test_wishes_that_do_not_fit_together(wish: Wish, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        sweep(100, 10, wish)


@pytest.mark.parametrize(
    ("rate", "duration", "message"),
    [
        (0.0, 1.0, "rate 0 Hz is not a positive number"),
        (float("nan"), 1.0, "rate nan Hz"),
        (100.0, float("inf"), "duration inf s"),
        (100.0, -1.0, "duration -1 s"),
        (100.0, 0.04, "0.04 s at 100 Hz are 5 samples, too few"),
        (1e6, 1e6, "samples, more than 1e"),
        (1e300, 1e300, "samples, more than 1e"),
    ],
)
def test_records_that_cannot_be(rate: float, duration: float, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        sweep(rate, duration, Wish(degree=4))


@pytest.mark.parametrize(
    ("frequency", "order", "message"),
    [
        (50.0, 0, "frequency 50 Hz is not between 0 and half the rate, 50 Hz"),
        (-1.0, 0, "frequency -1 Hz"),
        (float("nan"), 0, "frequency nan Hz"),
        ([1.0, 70.0], 0, "frequency 70 Hz"),
        (0.0, 1, "0 Hz with a derivative"),
        (1.0, 3, "derivative order 3 is not 0, 1 or 2"),
    ],
)
def test_frequencies_that_cannot_be(frequency: float, order: int, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        sweep(100, 10, Wish(degree=10), order, frequency)


def test_degree_too_high_for_the_record() -> None:
    with pytest.raises(NoAnswerError, match="degree 200 is too high for 1001 samples"):
        sweep(100, 10, Wish(degree=200))


def test_constants_pass() -> None:
    assert sweep(100, 10, Wish(degree=10), 0, 0.0).response.whole[0] == pytest.approx(1, abs=1e-13)


@pytest.mark.parametrize("fit", ["lsq", "quadrature", "smooth"])
def test_the_shortest_records(fit: str) -> None:
    for samples in range(6, 12):
        found = sweep(10, (samples - 1) / 10, Wish(degree=4, fit=fit))
        assert np.all(np.abs(found.response.inner) < 1.1)
        assert found.duration == pytest.approx((samples - 1) / 10)


# --- the command


@dataclass
class Run:
    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def freqresp(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Callable[..., Run]:
    """The command as typed, without the start of a new Python."""
    monkeypatch.setenv("CHEBID_QUIET", "")

    def run(*arguments: str) -> Run:
        monkeypatch.setattr(sys, "argv", ["chebid", "freqresp", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        assert isinstance(end.value.code, int)
        return Run(end.value.code, *capsys.readouterr())

    return run


def test_json_has_the_agreed_keys(freqresp) -> None:
    run = freqresp("--rate", "100", "--duration", "10", "--bandwidth", "2", "--order", "1", "--json", "--frequency",
                   "3", "1", "2")  # fmt: skip
    assert run.returncode == 0, run.stderr
    document = json.loads(run.stdout)
    agreed = {"degree", "bandwidth", "rate", "duration", "order", "fit", "cutoff", "response"}
    assert agreed <= document.keys()
    assert (document["degree"], document["order"], document["fit"]) == (63, 1, "lsq")
    assert [row["frequency"] for row in document["response"]] == [1, 2, 3]
    direct = response(operator(Wish(bandwidth=2.0)), [1, 2, 3], 1)
    for row, gain, phase in zip(document["response"], direct.gain_db, direct.phase_deg, strict=True):
        assert set(row) == {"frequency", "gain_db", "gain_db_whole", "phase_deg"}
        assert row["gain_db"] == pytest.approx(gain, abs=1e-9)
        assert row["phase_deg"] == pytest.approx(phase, abs=1e-9)


def test_table_figure_and_force(tmp_path: Path, freqresp) -> None:
    table, figure = tmp_path / "gain.csv", tmp_path / "gain.svg"
    options = ["--rate", "100", "--duration", "5", "--degree", "30", "-o", str(table), "--plot", str(figure)]
    first = freqresp(*options)
    assert first.returncode == 0, first.stderr
    assert "degree 30 on the whole record" in first.stdout
    assert table.read_text().startswith("frequency,gain_db,gain_db_whole,phase_deg\n")
    before = table.read_bytes(), figure.read_bytes()
    again = freqresp(*options)
    assert again.returncode == 2
    assert "exists already" in again.stderr and "--force" in again.stderr
    assert freqresp(*options, "--force").returncode == 0
    assert (table.read_bytes(), figure.read_bytes()) == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["gain.csv", "gain.svg"]


def test_wrong_usage_ends_with_status_2_and_a_hint(freqresp) -> None:
    run = freqresp("--rate", "100", "--duration", "10", "--degree", "5", "--frequency", "60")
    assert run.returncode == 2
    assert run.stderr.startswith("error: frequency 60 Hz") and "\nhint: " in run.stderr
    assert freqresp("--rate", "100", "--duration", "10", "--degree", "5", "7").returncode == 2
