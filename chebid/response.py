"""Frequency response of the operators that the other commands apply, of any fit, derivative order, window and penalty.

A sine exp(i w t), w = 2 pi f, goes through the `Operator` itself; what comes out is compared with what the ideal
operator makes of it, (i w)^k exp(i w t), by a complex fit

    G(f) = <ideal, output> / <ideal, ideal>        gain |G|, phase arg G

over |tau| < 0.9 of the record (the ends are another matter: the local cut-off there is fc / sqrt(1 - tau^2)) and over
the whole record. A ratio of rms values would give half the decibels, a ratio of maxima nothing that means anything.

`closed_form`: the gain of order 0 on a continuous record, over all of it, in the inner product of a family.
Source: Pham et al., JESA 46(6-7), 2012, section 2.4, which leaves the definition of the amplitudes open.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.optimize
import scipy.special
from numpy.typing import ArrayLike, NDArray

from chebid.basis import Array
from chebid.errors import UsageError
from chebid.projection import Operator, Plan, from_bandwidth

ComplexArray = NDArray[np.complex128]

INNER = 0.9  # |tau| below which the ends of a record do not count
THREE_DB = float(np.sqrt(0.5))  # gain at the cut-off
ORDERS = (0, 1, 2)
_FEWEST, _MOST = 6, 10_000_000  # samples of a record
_INSTANTS = 20_000  # at which the output is looked at; longer records are looked at here and there
_BATCH = 4_000_000  # samples of sines that go through the operator at once
_STEPS = 20  # frequencies tried around the cut-off before it is refined
_GRID = (25, 100)  # frequencies of the default grid: few where each is costly
_COST = 3e9  # samples times degrees times frequencies that take some ten seconds


# --- closed forms, of a continuous record


def closed_form(weight: str, degree: int, w: ArrayLike) -> Array:
    """Gain A of T_n on exp(i w tau) over [-1, 1], in the inner product of the family `weight`; w = pi f T, any shape.

    Projections by an inner product (eq. 9) have the weight of their basis; least squares (eq. 11) on many samples has
    that of Legendre, whatever the basis. A = sum_{k <= n} |c_k|^2 <P_k, P_k> / <1, 1>.
    """
    return np.sum(_shares(weight, degree, np.atleast_1d(np.asarray(w, dtype=float))), axis=0).reshape(np.shape(w))


def _shares(weight: str, degree: int, w: Array) -> Array:
    """What each polynomial adds to A: (n + 1, ...)."""
    k = np.arange(degree + 1.0).reshape(-1, *[1] * w.ndim)
    if weight == "chebyshev":  # Jacobi-Anger: c_k = (2 - delta_k0) i^k J_k(w)
        return np.where(k == 0, 1.0, 2.0) * scipy.special.jv(k, w) ** 2
    if weight == "chebyshev2":  # Abramowitz & Stegun 9.1.27 on the former: c_k = 2 (k + 1) i^k J_{k+1}(w) / w
        safe = np.where(w == 0, 1.0, w)
        return np.where(w == 0, k == 0, (2 * (k + 1) * scipy.special.jv(k + 1, safe) / safe) ** 2)
    if weight == "legendre":  # Abramowitz & Stegun 10.1.47: c_k = (2 k + 1) i^k j_k(w)
        return (2 * k + 1) * scipy.special.spherical_jn(k.astype(int), w) ** 2
    raise UsageError(f"no closed form for the weight {weight!r}", hint="choose chebyshev, chebyshev2 or legendre")


def linear_interpolation(frequency: ArrayLike, rate: float) -> Array:
    """Gain sinc^2(f / fs) of joining the samples by straight lines, as the quadrature of annex 5.1 does."""
    return np.sinc(np.asarray(frequency, dtype=float) / rate) ** 2


def decibel(gain: ArrayLike) -> Array:
    """20 log10 |gain|; minus infinity for a gain of zero."""
    with np.errstate(divide="ignore"):
        return 20 * np.log10(np.abs(gain))


# --- the operator as it is


@dataclass(frozen=True)
class Response:
    """Complex gains (F,) at `frequency` (F,) Hz of a derivative of that order, relative to the ideal one."""

    order: int
    frequency: Array
    inner: ComplexArray  # over |tau| < 0.9
    whole: ComplexArray

    @property
    def gain_db(self) -> Array:
        return decibel(self.inner)

    @property
    def gain_db_whole(self) -> Array:
        return decibel(self.whole)

    @property
    def phase_deg(self) -> Array:
        return np.degrees(np.angle(self.inner))


def response(operator: Operator, frequency: ArrayLike, order: int = 0) -> Response:
    """What `operator` makes of sines at `frequency` (F,) Hz.

    Raises UsageError for an order other than 0, 1, 2, for frequencies that are negative or not below half the rate, and
    for 0 Hz in a derivative, whose ideal is zero.
    """
    f = np.atleast_1d(np.asarray(frequency, dtype=float))
    _check(f, order, _rate(operator.t))
    probe = _shared_window(operator) if operator.layout.count > 1 and operator.uniform else _whole_record(operator)
    size = max(1, _BATCH // (2 * len(probe.operator.t)))
    parts = [probe.gains(f[i : i + size], order) for i in range(0, len(f), size)]
    inner, whole = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Response(order, f, inner, whole)


def _check(f: Array, order: int, rate: float) -> None:
    if order not in ORDERS:
        raise UsageError(
            f"derivative order {order} is not 0, 1 or 2", hint="0 gives positions, 1 velocities, 2 accelerations"
        )
    for value in f[~((f >= 0) & (f < rate / 2))]:
        raise UsageError(
            f"frequency {value:g} Hz is not between 0 and half the rate, {rate / 2:g} Hz",
            hint="samples cannot tell a higher frequency from a lower one; raise --rate or ask for lower frequencies",
        )
    if order and np.any(f == 0):
        raise UsageError(
            "frequency 0 Hz with a derivative: the ideal one is zero, and there is no gain relative to it",
            hint="leave 0 out, or take order 0",
        )


def _rate(t: Array) -> float:
    return (len(t) - 1) / float(t[-1] - t[0])


@dataclass(frozen=True)
class _Probe:
    """Sines go through `operator`; what comes out at instants `at` (M,) counts with weights `inner`, `whole` (M,)."""

    operator: Operator
    at: NDArray[np.intp]
    inner: Array
    whole: Array

    def gains(self, f: Array, order: int) -> tuple[ComplexArray, ComplexArray]:
        phase = 2 * np.pi * np.outer(self.operator.t, f)
        series = self.operator.fit(np.hstack([np.cos(phase), np.sin(phase)]))
        if len(self.at) == len(self.operator.t):
            output = self.operator.at_samples(series, order)
        else:
            output = series(self.operator.t[self.at], order)
        # the ideal has modulus w^k everywhere, so that <ideal, output> / <ideal, ideal> is a mean
        ideal = (2j * np.pi * f) ** order * np.exp(1j * phase[self.at])
        relative = (output[:, : len(f)] + 1j * output[:, len(f) :]) / ideal
        return self.inner @ relative / self.inner.sum(), self.whole @ relative / self.whole.sum()


def _whole_record(operator: Operator) -> _Probe:
    samples = len(operator.t)
    at = np.unique(np.round(np.linspace(0, samples - 1, min(samples, _INSTANTS))).astype(np.intp))
    inner = _inside(operator.t, operator.t[at])
    return _Probe(operator, at, inner, np.ones(len(at)))


def _shared_window(operator: Operator) -> _Probe:
    """One window for all of them, with the summed weights of their blend.

    On a uniform grid the local times of all windows are the same, and a sine in another window is the same sine with
    another phase, which the gain relative to the ideal does not see.
    """
    t, layout = operator.t, operator.layout
    first = np.searchsorted(t, layout.start - 0.25 / _rate(t))
    samples = round(2 * float(layout.half[0]) * _rate(t)) + 1
    inner, whole = np.zeros(samples), np.zeros(samples)
    for window in range(layout.count):
        where = layout.active(window, t)
        here = slice(where.start - first[window], where.stop - first[window])
        blend = layout.weight(window, t[where])
        whole[here] += blend
        inner[here] += blend * _inside(t, t[where])
    single = Operator(t[:samples] - t[0], replace(operator.plan, window=None))
    return _Probe(single, np.arange(samples), inner, whole)


def _inside(t: Array, at: Array) -> Array:
    """1 at those times of the record `t` where |tau| < 0.9, else 0."""
    # a sample at 0.9 itself is out on both sides, whatever the rounding
    return (np.abs(2 * (at - t[0]) / (t[-1] - t[0]) - 1) < INNER * (1 - 1e-9)).astype(float)


def cutoff(operator: Operator, order: int = 0) -> float | None:
    """The lowest frequency in Hz at which the gain over |tau| < 0.9 falls to -3.01 dB; None if there is none."""
    rate, span = _rate(operator.t), float(operator.t[-1] - operator.t[0])

    def excess(f: ArrayLike) -> Array:
        return np.abs(response(operator, f, order).inner) - THREE_DB

    bracket = _bracket(excess, operator.plan.bandwidth or operator.plan.degree / (np.pi * span), rate / 2)
    if bracket is None:
        return None
    return float(scipy.optimize.brentq(lambda f: float(excess(f)[0]), *bracket, xtol=1e-10 * bracket[1], rtol=1e-12))


def _bracket(excess: Callable[[Array], Array], guess: float, nyquist: float) -> tuple[float, float] | None:
    """Two frequencies around the first fall through zero: near the guess, else below it or up to half the rate."""
    top = nyquist * (1 - 1e-9)

    def scan(low: float, high: float) -> tuple[Array, Array]:
        f = np.geomspace(min(low, top), min(high, top), _STEPS)
        return f, excess(f)

    f, values = scan(0.7 * guess, 1.5 * guess)
    if values[0] <= 0:
        f, values = scan(0.01 * guess, 0.7 * guess)
    elif np.all(values > 0):
        f, values = scan(1.5 * guess, top)
    falls = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
    return (float(f[falls[0]]), float(f[falls[0] + 1])) if len(falls) else None


# --- what a user asks for


@dataclass(frozen=True)
class Sweep:
    """The response of one plan on a record of that `rate` (Hz) and `duration`; lengths in s, `cutoff` in Hz."""

    plan: Plan
    rate: float
    duration: float
    windows: int
    window_length: float
    cutoff: float | None
    response: Response

    def document(self) -> dict[str, Any]:
        """For JSON: numbers, with None where there is none."""
        rows = zip(*self.columns().values(), strict=True)
        return {
            "degree": self.plan.degree,
            "bandwidth": self.plan.bandwidth,
            "rate": self.rate,
            "duration": self.duration,
            "order": self.response.order,
            "fit": self.plan.fit,
            "basis": self.plan.basis,
            "windows": self.windows,
            "window": self.window_length,
            "penalty": self.plan.penalty if np.isfinite(self.plan.penalty) else None,
            "cutoff": self.cutoff,
            "response": [dict(zip(self.columns(), map(_number, row), strict=True)) for row in rows],
        }

    def sentence(self) -> str:
        """The operator and its cut-off in words."""
        plan, order = self.plan, self.response.order
        length = self.duration if self.windows == 1 else self.window_length
        where = "the whole record" if self.windows == 1 else f"each of {self.windows} overlapping windows"
        penalty = f", penalty with half gain at {plan.penalty:.4g} Hz" if np.isfinite(plan.penalty) else ""
        found = f"-3 dB at {self.cutoff:.5g} Hz" if self.cutoff else "no -3 dB point below half the rate"
        return (
            f"fit {plan.fit}, basis {plan.basis}: degree {plan.degree} on {where} ({length:.4g} s at {self.rate:g} Hz)"
            f"{penalty}.\nderivative order {order}: {found}, over the inner {100 * INNER:.0f} % of the record."
        )

    def columns(self) -> dict[str, Array]:
        """The table: frequency Hz, gains dB over |tau| < 0.9 and over the whole record, phase deg; (F,) each."""
        r = self.response
        return {
            "frequency": r.frequency,
            "gain_db": r.gain_db,
            "gain_db_whole": r.gain_db_whole,
            "phase_deg": r.phase_deg,
        }


def _number(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def clock(rate: float, duration: float) -> Array:
    """Instants (N,) in s of a record. Raises UsageError when it is too short, or longer than any answer needs."""
    for name, value, unit in (("rate", rate, "Hz"), ("duration", duration, "s")):
        if not (np.isfinite(value) and value > 0):
            raise UsageError(f"{name} {value:g} {unit} is not a positive number", hint=f"give the {name} of your log")
    samples = int(min(rate * duration * (1 + 1e-12) + 1, 1e18))
    if samples < _FEWEST:
        raise UsageError(
            f"{duration:g} s at {rate:g} Hz are {samples} samples, too few for any projection (at least {_FEWEST})",
            hint="is the rate in Hz and the duration in s?",
        )
    if samples > _MOST:
        raise UsageError(
            f"{duration:g} s at {rate:g} Hz are {samples:.3g} samples, more than {_MOST:.0e}",
            hint="gains depend on degree / duration only: ask for a shorter record and a lower degree",
        )
    return np.arange(samples) / rate


@dataclass(frozen=True)
class Wish:
    """A plan asked for without data: `degree` or `bandwidth` Hz; with a degree also `window` s and `penalty` Hz."""

    degree: int | None = None
    bandwidth: float | None = None
    fit: str = "lsq"
    basis: str = "chebyshev"
    window: float | None = None
    penalty: float | None = None


def plan_for(t: Array, wish: Wish) -> Plan:
    """The plan that the other commands make of the same wish. Raises UsageError when its parts do not fit together.

    Where they would choose the penalty from the data, it gets its -3 dB point at degree / (pi T), T of the window.
    """
    if (wish.degree is None) == (wish.bandwidth is None):
        raise UsageError("give either a degree or a bandwidth", hint="for example --degree 125, or --bandwidth 8 (Hz)")
    if wish.penalty is not None and wish.fit != "smooth":
        raise UsageError(f"a penalty does not go with fit {wish.fit}", hint="take --fit smooth, or leave it out")
    if wish.bandwidth is not None:
        if wish.window is not None or wish.penalty is not None:
            raise UsageError("a bandwidth chooses its own window and penalty", hint="set them with --degree instead")
        return from_bandwidth(t, wish.bandwidth, wish.fit, wish.basis)
    return _plan_of_degree(t, wish, wish.degree or 0)


def _plan_of_degree(t: Array, wish: Wish, degree: int) -> Plan:
    lowest = 4 if wish.fit == "smooth" else 1
    if degree < lowest:
        raise UsageError(f"degree {degree} is below {lowest}", hint="the paper uses 125")
    span = float(t[-1] - t[0])
    if wish.window is not None and not 0 < wish.window <= span:
        raise UsageError(f"window {wish.window:g} s is not between 0 and the duration, {span:g} s", hint="leave it out")
    cut = degree / (np.pi * (wish.window or span))
    if wish.fit != "smooth":
        return Plan(wish.fit, wish.basis, degree, wish.window, np.inf, cut, "degree as set")
    if wish.penalty is not None and not wish.penalty > 0:
        raise UsageError(f"penalty {wish.penalty:g} Hz is not positive", hint="it is the frequency of gain 1/2")
    penalised = from_bandwidth(t, cut, "smooth", wish.basis)
    ratio = penalised.bandwidth / penalised.penalty  # of the -3 dB frequency to that of gain 1/2
    penalty = wish.penalty or penalised.penalty
    return Plan("smooth", wish.basis, degree, wish.window, penalty, min(ratio * penalty, cut), "degree as set")


def sweep(rate: float, duration: float, wish: Wish, order: int = 0, frequency: ArrayLike | None = None) -> Sweep:
    """The response at `frequency` (F,) Hz, or on a grid up to twice the cut-off (below half the rate).

    Raises UsageError for what cannot be asked, NoAnswerError for a degree too high for the record.
    """
    t = clock(rate, duration)
    operator = Operator(t, plan_for(t, wish))
    if frequency is not None:
        _check(np.atleast_1d(np.asarray(frequency, dtype=float)), order, _rate(t))
    cut = cutoff(operator, order)
    if frequency is None:
        frequency = _grid(operator, cut)
    found = response(operator, frequency, order)
    layout = operator.layout
    return Sweep(operator.plan, rate, float(t[-1]), layout.count, float(2 * layout.half[0]), cut, found)


def _grid(operator: Operator, cut: float | None) -> Array:
    nyquist = _rate(operator.t) / 2 * (1 - 1e-9)
    work = len(operator.t) * operator.plan.degree if operator.layout.count == 1 else 1
    count = int(np.clip(_COST / work, *_GRID))
    return np.linspace(0, min(2 * cut, nyquist) if cut else nyquist, count + 1)[1:]
