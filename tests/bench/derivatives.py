"""Accelerations from encoder readings: chebid, left to itself, against differentiators tuned with the truth.

    python -m tests.bench.derivatives [--seeds N] [--duration S] [--signal NAME ...] [--worst R]

Every peer gets, for every record, and for the whole of it and its inner 90 % apart, the settings of its grid that come
closest to the true acceleration, which no user has; chebid gets samples. Errors, ||estimate - truth|| / ||truth||, in
%, are root mean squares over the seeds; the ratio is chebid's over that of the best peer. The first table is of the
multisine, the rest of the other motions in `signals`. With --worst R a ratio above R in the first table exits with 1.

Peers beyond scipy are used when they are there: python -m pip install pynumdiff
"""

import argparse
import sys
import warnings
from collections.abc import Callable, Iterator

import numpy as np
from scipy.interpolate import make_lsq_spline
from scipy.signal import butter, savgol_filter, sosfiltfilt

from chebid.projection import Setting, project
from tests.bench.signals import COARSE, FINE, MOTIONS, Encoder

Array = np.ndarray
Peer = Callable[[Array, float], Iterator[Array]]  # samples, step -> an acceleration for each setting of a grid

COLUMNS: tuple[tuple[str, float, Encoder], ...] = (
    ("100 Hz, 16 bit", 100.0, FINE),
    ("100 Hz, 13 bit + noise", 100.0, COARSE),
    ("1 kHz, 13 bit + noise", 1000.0, COARSE),
)
CHEBID = "chebid, automatic"


def _windows(samples: int, shortest: int, step: float, longest: float) -> list[int]:
    """Odd numbers of samples, evenly spread in their logarithm, up to `longest` s."""
    most = min(longest / step, samples / 2)
    return sorted({int(w) // 2 * 2 + 1 for w in np.geomspace(shortest, most, 24)})


def savitzky_golay(x: Array, step: float) -> Iterator[Array]:
    """Local polynomials of degree 2 to 9, windows up to 3 s."""
    for degree in range(2, 10):
        for window in _windows(len(x), degree + 2, step, 3.0):
            if window > degree:
                yield savgol_filter(x, window, degree, deriv=2, delta=step)


def butterworth(x: Array, step: float) -> Iterator[Array]:
    """Forward and backward, order 2 to 8, cut-offs of 1 Hz to 0.45 of the rate; then central differences twice."""
    for order in (2, 4, 6, 8):
        for cut in np.geomspace(1.0, 0.45 / step, 32):
            sos = butter(order, cut, fs=1 / step, output="sos")
            padding = min(len(x) - 1, int(3 / (cut * step)) + 20)
            smooth = sosfiltfilt(sos, x, padlen=padding)
            yield np.gradient(np.gradient(smooth, step, edge_order=2), step, edge_order=2)


def _spline(degree: int) -> Peer:
    def accelerations(x: Array, step: float) -> Iterator[Array]:
        t = step * np.arange(len(x))
        for pieces in np.unique(np.geomspace(4, len(x) / 1.6, 64).astype(int)):
            knots = np.concatenate([[0.0] * degree, np.linspace(0, t[-1], pieces + 1), [t[-1]] * degree])
            yield make_lsq_spline(t, x, knots, degree)(t, 2)

    return accelerations


def rtsdiff(x: Array, step: float) -> Iterator[Array]:
    """Kalman smoother, constant derivative of order 2 or 3; its velocity smoothed again, or differenced."""
    from pynumdiff.kalman_smooth import rtsdiff as smoother

    for order in (2, 3):
        for ratio in np.arange(3.0, 18.0):
            for both in (False, True):
                velocity = smoother(x, step, order, ratio, both)[1]
                yield np.gradient(velocity, step, edge_order=2)
                yield smoother(velocity, step, order, ratio, both)[1]


def polydiff(x: Array, step: float) -> Iterator[Array]:
    """Sliding polynomials of degree 3 to 8, blended; the velocity fitted again, or differenced."""
    from pynumdiff.polynomial_fit import polydiff as fit

    for degree in (3, 4, 5, 6, 7, 8):
        for window in _windows(len(x), 2 * degree + 3, step, 3.0)[::2]:
            stride = max(1, window // 12)
            velocity = fit(x, step, degree=degree, window_size=window, stride=stride)[1]
            yield np.gradient(velocity, step, edge_order=2)
            yield fit(velocity, step, degree=degree, window_size=window, stride=stride)[1]


PEERS: dict[str, Peer] = {
    "Savitzky-Golay": savitzky_golay,
    "Butterworth + central differences": butterworth,
    "B-spline least squares, degree 6": _spline(6),
    "B-spline least squares, degree 7": _spline(7),
}
OPTIONAL: dict[str, Peer] = {"pynumdiff rtsdiff": rtsdiff, "pynumdiff polydiff": polydiff}


def chebid(x: Array, step: float) -> Iterator[Array]:
    """One answer, without any setting."""
    t = step * np.arange(len(x))
    yield project(t, x, Setting()).at(t, 2)


def available() -> dict[str, Peer]:
    """The peers that are installed; what is missing is said on stderr."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import pynumdiff  # noqa: F401
    except ImportError:
        print("pynumdiff is left out: python -m pip install pynumdiff", file=sys.stderr)
        return PEERS
    return PEERS | OPTIONAL


def errors(found: Iterator[Array], truth: Array) -> tuple[float, float]:
    """The least error in %, over the whole record, and over its inner 90 %."""
    end = len(truth) // 20
    whole, inner = np.inf, np.inf
    for one in found:
        off = one - truth
        whole = min(whole, float(np.linalg.norm(off) / np.linalg.norm(truth)))
        inner = min(inner, float(np.linalg.norm(off[end:-end]) / np.linalg.norm(truth[end:-end])))
    return 100 * whole, 100 * inner


def column(motion: str, rate: float, encoder: Encoder, duration: float, seeds: int) -> dict[str, Array]:
    """Errors (seeds, 2) of every method."""
    methods = {CHEBID: chebid} | available()
    out: dict[str, list[tuple[float, float]]] = {name: [] for name in methods}
    t = np.arange(int(duration * rate) + 1) / rate
    for seed in range(seeds):
        q, _, truth = MOTIONS[motion](seed, duration)(t)
        x = encoder.measure(q, seed)
        for name, method in methods.items():
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")  # of peers, at settings that do not suit them
                out[name].append(errors(method(x, 1 / rate), truth))
    return {name: np.array(values) for name, values in out.items()}


def _mean(errors: Array) -> Array:
    return np.sqrt(np.mean(errors**2, axis=0))


def show(motion: str, duration: float, seeds: int) -> float:
    """Print the table of one motion; the largest ratio."""
    columns = [(title, column(motion, rate, encoder, duration, seeds)) for title, rate, encoder in COLUMNS]
    print(f"\n{motion}, {duration:g} s, {seeds} seeds: error of the acceleration in %, whole record | inner 90 %")
    print(" " * 36 + "".join(f"{title:>24}" for title, _ in columns))
    for name in columns[0][1]:
        cells = [_mean(found[name]) for _, found in columns]
        print(f"{name:36}" + "".join(f"{f'{whole:.3g} | {inner:.3g}':>24}" for whole, inner in cells))
    verdicts = [_verdict(found) for _, found in columns]
    print(f"{'ratio to the best peer':36}" + "".join(f"{f'{a:.2f} | {b:.2f}':>24}" for (a, b), _, _ in verdicts))
    print(f"{'records on which no peer is better':36}" + "".join(f"{f'{a} | {b}':>24}" for _, _, (a, b) in verdicts))
    for (title, _), (_, best, _) in zip(columns, verdicts, strict=True):
        print(f"best peer at {title}: {' | '.join(best)}")
    sys.stdout.flush()
    return float(np.max([ratio for ratio, _, _ in verdicts]))


def _verdict(found: dict[str, Array]) -> tuple[Array, list[str], Array]:
    """Of one column, whole and inner: ratio to the best peer, its name, and on how many records none is better."""
    names = [name for name in found if name != CHEBID]
    peers = np.array([_mean(found[name]) for name in names])
    ratio = _mean(found[CHEBID]) / peers.min(axis=0)
    everyone = np.min([found[name] for name in names], axis=0)
    return ratio, [names[i] for i in peers.argmin(axis=0)], np.sum(found[CHEBID] <= everyone, axis=0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--duration", type=float, default=10.0)
    parser.add_argument("--signal", nargs="+", choices=MOTIONS, default=list(MOTIONS), metavar="NAME")
    parser.add_argument("--worst", type=float, default=np.inf)
    given = parser.parse_args()
    worst = {motion: show(motion, given.duration, given.seeds) for motion in given.signal}
    print("\nlargest ratio: " + ", ".join(f"{motion} {ratio:.2f}" for motion, ratio in worst.items()))
    sys.exit(int(worst[given.signal[0]] > given.worst))


if __name__ == "__main__":
    main()
