"""Choosing the operator: from what the user set (degree, bandwidth, fit), or from the data when nothing is set.

From the data: the most likely penalty (see `spectrum`). A first look by periodograms (`whittle`) tells how wide a band
to resolve; restricted maximum likelihood (`likelihood`) on tiles that resolve it compares shapes near by, and says how
wide the next look has to be, until that stays. Degree and windows follow from where the penalty lets nothing pass any
more. The projections without a penalty are cut where it has half its gain: there signal and noise are equal.
"""

from dataclasses import dataclass, replace

import numpy as np

from chebid.basis import Array
from chebid.errors import NoAnswerError, UsageError
from chebid.projection.clock import is_uniform, rate_of
from chebid.projection.layout import usual_samples
from chebid.projection.likelihood import Likely
from chebid.projection.operator import Operator
from chebid.projection.plan import Plan, limit
from chebid.projection.sampled import Sampled
from chebid.projection.threads import single
from chebid.projection.whittle import SLOPES, first_look

_FEWEST = 24  # samples of a record from which anything can be chosen
_DEGREE = 125  # of a tile
_LOOKS = 4
_NOTHING = 0.03  # gain of the penalty at which nothing passes any more
_WIDER = 1.25  # times that frequency is what tiles resolve
_SHARES = tuple(0.95 * 2 ** (-j / 4) for j in range(24))  # bands tried, as shares of the cut
_NEAR = 2.1  # factor between the band of one look and those tried at the next
_SINGLE = 320  # highest degree of one polynomial for the whole record
_WINDOW = 160  # degree of a window
_TWICE = 100_000  # uneven samples up to which the choice is made twice
_LEAST = 12  # degree
_LARGEST = 1 << 23  # samples times degree of a window: 64 MB
_MARGIN = 1.25  # windows are planned for 1.25 times the bandwidth asked for: gain 1 up to it at every place
_SHARP = 2.5  # n <= 2.5 sqrt(N) in a window of the unpenalised fits
_THREE_DB = (np.sqrt(2) - 1) ** 0.125  # of 1 / (1 + (f / f0)^8)


@dataclass(frozen=True)
class Setting:
    """What the user set of a projection; None is automatic. `bandwidth` in Hz, `degree` of the whole record."""

    fit: str | None = None
    basis: str = "chebyshev"
    degree: int | None = None
    bandwidth: float | None = None


@single
def plan(t: Array, x: Array, setting: Setting) -> Plan:
    """The plan for one signal x (N,) at t (N,) s.

    Raises UsageError when degree and bandwidth are both set or not positive, NoAnswerError when the record is too
    short.
    """
    if setting.degree is not None and setting.bandwidth is not None:
        raise UsageError(
            "both a degree and a bandwidth are set", hint="set one of them: degree = pi * bandwidth * duration"
        )
    if setting.degree is not None:
        return _from_degree(t, x, setting.degree, setting)
    if setting.bandwidth is not None:
        return from_bandwidth(t, setting.bandwidth, setting.fit or "lsq", setting.basis)
    return _from_data(t, x, setting)


# --- without data


def from_bandwidth(t: Array, bandwidth: float, fit: str = "lsq", basis: str = "chebyshev") -> Plan:
    """The plan that passes everything up to `bandwidth` Hz on a record at t (N,) s. Needs no data."""
    span, rate = float(t[-1] - t[0]), rate_of(t)
    if not 0 < bandwidth < rate / 2:
        raise UsageError(
            f"bandwidth {bandwidth:g} Hz is not between 0 and half the rate, {rate / 2:g} Hz",
            hint="robot motion is usually below 20 Hz; leave it out and chebid chooses it",
        )
    if fit == "smooth":
        return _within_reach(_smooth_plan(span, bandwidth, basis), t)
    degree = max(1, round(np.pi * bandwidth * span))
    if degree <= 3 * np.sqrt(len(t)):
        return Plan(fit, basis, degree, None, np.inf, degree / (np.pi * span), f"degree = pi {bandwidth:g} Hz T")
    longest = min((_SHARP / (_MARGIN * np.pi * bandwidth)) ** 2 * rate, _WINDOW / (_MARGIN * np.pi * bandwidth))
    window = _fitting(span, max(longest, _FEWEST / rate))
    degree = max(int(_MARGIN * np.pi * bandwidth * window), 1)
    reason = f"windows of {window:.3g} s, so that n <= {_SHARP} sqrt(N) at {bandwidth:g} Hz"
    return _within_reach(Plan(fit, basis, degree, window, np.inf, bandwidth, reason), t)


def _within_reach(plan: Plan, t: Array) -> Plan:
    """The plan with a degree that the samples of a usual window bear; emptier ones take what they bear."""
    return replace(plan, degree=min(plan.degree, limit(plan.fit, usual_samples(t, plan.window))))


def _smooth_plan(span: float, bandwidth: float, basis: str) -> Plan:
    """Penalty with its -3 dB point at the bandwidth, on windows whose degree resolves 1.5 times the half-gain point."""
    half_gain = bandwidth / _THREE_DB
    window = _fitting(span, min(span, _DEGREE / (1.5 * np.pi * half_gain)))
    degree = max(int(1.5 * np.pi * half_gain * window), 12)
    reason = f"penalty with -3 dB at {bandwidth:g} Hz"
    return Plan("smooth", basis, degree, window if window < span else None, half_gain, bandwidth, reason)


def _fitting(span: float, window: float) -> float:
    """The length near `window` s of half-overlapping windows that fit a record of `span` s."""
    return 2 * span / (max(1, round(2 * span / window - 1)) + 1)


# --- from the data


def _from_degree(t: Array, x: Array, degree: int, setting: Setting) -> Plan:
    if degree < 1:
        raise UsageError(f"degree {degree} is below 1", hint="the paper uses 125; leave it out and chebid chooses it")
    span = float(t[-1] - t[0])
    fit, cut = setting.fit or "lsq", degree / (np.pi * span)
    given = Plan(fit, setting.basis, degree, None, np.inf, cut, "degree as set")
    if fit != "smooth":
        return given
    Operator(t, given)  # the guard on the degree
    shapes = [(2, 0.0)] if degree > _SINGLE else _shapes(1.0, np.inf)
    return _penalised(given, Sampled.of(t, x).whole(degree).best(shapes), "degree as set, ")


def _from_data(t: Array, x: Array, setting: Setting) -> Plan:
    if len(t) < _FEWEST:
        raise NoAnswerError(f"a record of {len(t)} samples is too short to choose a filter", hint="record at least 1 s")
    found = _search(Sampled.of(t, x))
    if not is_uniform(t) and len(t) <= _TWICE:
        found = _search(_interpolated(t, x, _penalised(_resolving(t, found, setting.basis), found)))
    if setting.fit in (None, "smooth"):
        return _penalised(_resolving(t, found, setting.basis), found)
    bandwidth = np.clip(found.half, _LEAST / (np.pi * float(t[-1] - t[0])), 0.2 * rate_of(t))
    return from_bandwidth(t, float(bandwidth), setting.fit or "lsq", setting.basis)


def _interpolated(t: Array, x: Array, first: Plan) -> Sampled:
    """The signal between its uneven stamps: by a first plan, and straight lines through the noise that this leaves."""
    operator, grid = Operator(t, first), np.linspace(t[0], t[-1], len(t))
    series = operator.fit(x)
    noise = x - operator.at_samples(series)[:, 0]
    return Sampled.of(grid, series(grid)[:, 0] + np.interp(grid, t, noise))


def _search(sampled: Sampled) -> Likely:
    """The most likely penalty: every look gives the band of the next one."""
    shape, half = first_look(sampled.segments(), sampled.rate)
    found, seen = Likely(np.inf, shape, half), set[int]()
    while len(seen) < _LOOKS:
        rung = sampled.rung(_WIDER * found.spectrum.frequency(_NOTHING, found.half))
        if rung in seen:
            break
        seen.add(rung)
        tiles = sampled.tiles(rung, _DEGREE)
        found = tiles.best(_shapes(found.spectrum.band / tiles.cut, _NEAR))
    return found


def _shapes(share: float, near: float) -> list[tuple[int, float]]:
    """Shapes (slope, band as a share of the cut) about that band, and the two without one."""
    around = [one for one in _SHARES if share / near < one < share * near]
    return [(1, 0.0), (2, 0.0), *((slope, one) for slope in SLOPES for one in around)]


def _resolving(t: Array, found: Likely, basis: str) -> Plan:
    """One polynomial for the record, or windows, whose degree resolves all that the penalty lets pass."""
    span, rate = float(t[-1] - t[0]), rate_of(t)
    cut = min(1.1 * found.spectrum.frequency(_NOTHING, found.half), 0.55 * rate)
    window = span
    if np.pi * cut * span > _SINGLE or np.pi * cut * span * len(t) > _LARGEST:
        window = min(_WINDOW / (np.pi * cut), np.sqrt(_LARGEST / (np.pi * cut * rate)))
    while True:
        degree = max(_LEAST, int(np.ceil(np.pi * cut * window)))
        made = Plan("smooth", basis, degree, window if window < 0.75 * span else None, np.inf, cut)
        most = limit("smooth", usual_samples(t, made.window))
        if degree <= most or made.window is None:
            return replace(made, degree=min(degree, most))
        window *= 1.5  # a gap in the record: windows must reach across


def _penalised(plan: Plan, found: Likely, why: str = "") -> Plan:
    """The plan with that penalty."""
    shape = found.spectrum
    bandwidth = min(shape.frequency(float(np.sqrt(0.5)), found.half), plan.bandwidth)
    above = f" above {shape.band:.3g} Hz" if shape.band else ""
    reason = f"{why}penalty of restricted maximum likelihood: accelerations fall with slope {shape.slope}{above}"
    return replace(plan, penalty=found.half, bandwidth=bandwidth, slope=shape.slope, band=shape.band, reason=reason)
