"""Equations by the classical recipe (Gautier): zero-phase Butterworth on q, central differences, decimated rows.

Used by `wls` and `huber`. Decimation is that of the signal-processing tool boxes: Chebyshev type I of order 8 with
0.05 dB ripple at 0.8 of the new Nyquist frequency, forward and backward, on every column and on the torque.
"""

from dataclasses import dataclass

import numpy as np
import scipy.ndimage
import scipy.signal
from numpy.typing import NDArray

from chebid.basis import Array
from chebid.dynamics import Dynamics
from chebid.effects import Motion
from chebid.equations.gate import fast_enough
from chebid.equations.rows import JointNoise, Rows, merge
from chebid.errors import NoAnswerError
from chebid.log import Record

_KEPT = 0.8  # of the new Nyquist frequency, passed by the decimation
_FIRST = np.array([-1, 9, -45, 0, 45, -9, 1]) / 60  # d/dt of accuracy 6 (Fornberg, Math. Comp. 51, 1988)
_SECOND = np.array([2, -27, 270, -490, 270, -27, 2]) / 180
_ORDER = 8  # of the decimation filter


@dataclass(frozen=True)
class FilterSettings:
    """`cutoff` Hz and `order` of the Butterworth filter, `decimate` by a factor, `drop` samples at the start.

    `trim` s at both ends and `gate` (J,) are zero in a published recipe that has none. `parallel`: the torque passes
    through the same filter as the position, and the differences are of accuracy 6: second-order ones at 100 Hz bias an
    inertia by more than its standard deviation. Published recipes have neither.
    """

    cutoff: float
    order: int = 4
    decimate: int = 1
    drop: int = 0
    trim: float = 0.0
    gate: tuple[float, ...] | None = None
    parallel: bool = False


def filtered_rows(records: list[Record], dynamics: Dynamics, settings: FilterSettings, delay: float = 0.0) -> Rows:
    """Rows of all records. Raises NoAnswerError when a record is too short for the filters or nothing is left."""
    rows = merge([_record_rows(record, dynamics, settings, delay) for record in records])
    for j, noise in enumerate(rows.noise):
        if noise.samples == 0:
            raise NoAnswerError(
                f"joint {dynamics.joints[j]} has no sample left", hint="lower the gate, the trim or the drop"
            )
    return rows


def _record_rows(record: Record, dynamics: Dynamics, settings: FilterSettings, delay: float) -> Rows:
    t, motion, tau = filtered_motion(record, settings, delay)
    used = np.repeat(_known(record, t, 0.5 / settings.cutoff)[:, None], tau.shape[1], axis=1)
    if settings.gate is not None:
        signs = [dynamics.signs(joint) for joint in range(tau.shape[1])]
        used &= fast_enough(motion.dq, np.asarray(settings.gate), signs)
    cut = round(settings.trim / (t[1] - t[0]))
    kept = slice(max(settings.drop, cut), len(t) - cut)
    if kept.stop - kept.start < 64:
        raise NoAnswerError("too few samples are left of a record", hint="record longer, or lower trim and drop")
    system = np.concatenate([dynamics.regressor(motion), tau[:, :, None]], axis=2)
    system = np.where(used[:, :, None], system, 0.0)[kept]
    return _stack(system, used[kept], settings, 1 / float(t[1] - t[0]))


def filtered_motion(record: Record, settings: FilterSettings, delay: float = 0.0) -> tuple[Array, Motion, Array]:
    """t (N,), motion and torque (N, J) on an even grid: the filters of this recipe know no other."""
    t, q, tau = _even(record, delay)
    step = float(t[1] - t[0])
    if not 0 < settings.cutoff < 0.5 / step:
        raise NoAnswerError(
            f"cutoff of {settings.cutoff:g} Hz is not below half the rate, {0.5 / step:g} Hz",
            hint="lower methods: wls: cutoff",
        )
    if len(t) <= 3 * settings.order:
        raise NoAnswerError(f"a record of {len(t)} samples is too short for this filter", hint="record longer")
    sections = scipy.signal.butter(settings.order, 2 * settings.cutoff * step, output="sos")
    q = zero_phase(sections, settings.order, q)
    if settings.parallel:
        tau = zero_phase(sections, settings.order, tau)
        return t, Motion(t, q, _stencil(q, _FIRST / step), _stencil(q, _SECOND / step**2)), tau
    dq = np.gradient(q, step, axis=0)
    return t, Motion(t, q, dq, np.gradient(dq, step, axis=0)), tau


def _stencil(q: Array, weights: Array) -> Array:
    """Differences of accuracy 6 along the first axis (N, J); the three samples at each end repeat their neighbours."""
    inner = scipy.ndimage.correlate1d(q, weights, axis=0, mode="nearest")
    inner[:3], inner[-3:] = inner[3], inner[-4]
    return inner


def _even(record: Record, delay: float) -> tuple[Array, Array, Array]:
    assert record.tau is not None, "require_torque comes first"
    tau = record.tau
    good = np.isfinite(record.q).all(axis=1) & np.isfinite(tau).all(axis=1)
    if record.uniform and good.all() and not delay:
        t = np.linspace(record.t[0], record.t[-1], len(record.t))
        return t, record.q, tau
    t = np.linspace(record.t[0], record.t[-1], max(2, round(record.duration * record.rate) + 1))
    known = record.t[good]

    def on(times: Array, columns: Array) -> Array:
        return np.column_stack([np.interp(t, times, column[good]) for column in columns.T])

    return t, on(known, record.q), on(known - delay, tau)


def _known(record: Record, t: Array, longest: float) -> NDArray[np.bool_]:
    """Which instants t (N,) lie outside, by that much, every stretch without positions of more than `longest` s."""
    known = record.t[np.isfinite(record.q).all(axis=1)]
    known = np.concatenate([[record.t[0]], known, [record.t[-1]]])
    out = np.ones(len(t), dtype=bool)
    for gap in np.flatnonzero(np.diff(known) > longest):
        out &= (t <= known[gap] - longest) | (t >= known[gap + 1] + longest)
    return out


def _stack(system: Array, used: NDArray[np.bool_], settings: FilterSettings, rate: float) -> Rows:
    joints = system.shape[1]
    factor = settings.decimate
    thinned = decimate(system, factor)
    share = np.ones(thinned.shape[:2]) if used.all() else decimate(used.astype(float), factor)
    kept = share > 0.5
    parts = [thinned[kept[:, j], j] for j in range(joints)]
    grams = np.einsum("njp,njq->jpq", system, system, optimize=True)
    # a filtered torque shows no noise out of band: its rows stand for themselves
    samples = [len(part) for part in parts] if settings.parallel else [int(n) for n in used.sum(axis=0)]
    index = [np.flatnonzero(kept[:, j]) for j in range(joints)]
    rows = np.concatenate(parts)
    return Rows(
        W=rows[:, :-1],
        Y=rows[:, -1],
        joint=np.repeat(np.arange(joints), [len(part) for part in parts]),
        frequency=np.full(len(rows), min(settings.cutoff, _KEPT * rate / (2 * factor))),
        block=np.concatenate(index) // max(1, int(rate / factor)),
        noise=tuple(JointNoise(grams[j], samples[j], float(len(parts[j]))) for j in range(joints)),
        serial=True,
        repeat=1.0 if settings.parallel else float(factor),
        passed=_passed(settings, rate),
    )


def _passed(settings: FilterSettings, rate: float) -> float:
    """Share of the band that rows can hold which is left on the torque."""
    share = _KEPT if settings.decimate > 1 else 1.0
    return min(share, 2 * settings.decimate * settings.cutoff / rate) if settings.parallel else share


def decimate(x: Array, factor: int) -> Array:
    """Every `factor`-th sample along the first axis, low-passed; the last sample kept is the last of x."""
    if factor <= 1:
        return x
    sections = scipy.signal.cheby1(_ORDER, 0.05, _KEPT / factor, output="sos")
    out = len(x) // factor + (len(x) % factor > 0)
    first = factor - (factor * out - len(x)) - 1
    return zero_phase(sections, _ORDER, x)[first::factor]


def zero_phase(sections: Array, order: int, x: Array) -> Array:
    """Filter forward and backward along the first axis, ends reflected over 3 x order samples: published figures of
    this recipe depend on that length in their fourth digit.
    """
    return scipy.signal.sosfiltfilt(sections, x, axis=0, padlen=3 * order)
