"""How fast projections are, one thread, as ratios within one run; results that are compared are equal.

    python -m tests.bench.speed [--quick] [--plot FILE]

1. Least squares on N samples, degree n, against numpy.polynomial.chebyshev.chebfit. `first` is the first projection on
   a grid, `again` that of a further signal, `uneven` one on stamps without any order.
2. Memory of a projection: growth of the peak resident size, each in a process of its own.
3. Position, velocity and acceleration of a million samples, all chosen from the data, against a Butterworth filter
   (scipy sosfiltfilt) and two gradients, which somebody must have set; and with a bandwidth that is set.
4. Cost from 1e3 to 1e7 samples, with the exponent of a fit; --plot draws it.

--quick leaves out what takes more than a few seconds.
"""

import os

for _name in ("OPENBLAS", "OMP", "MKL", "NUMBA"):
    os.environ.setdefault(f"{_name}_NUM_THREADS", "1")

import argparse  # noqa: E402
import subprocess  # noqa: E402
import sys  # noqa: E402
import time  # noqa: E402
from collections.abc import Callable  # noqa: E402
from pathlib import Path  # noqa: E402
from typing import TypeVar  # noqa: E402

import numpy as np  # noqa: E402
from numpy.polynomial import chebyshev  # noqa: E402
from scipy.signal import butter, sosfiltfilt  # noqa: E402

from chebid.projection import Operator, Plan, Setting, project  # noqa: E402
from chebid.projection.normal import _uniform_factors  # noqa: E402
from tests.bench.signals import COARSE, multisine  # noqa: E402

Array = np.ndarray
Result = TypeVar("Result")
TARGETS = {(10_000, 125): 30, (100_000, 200): 90, (100_000, 632): 300}
EQUAL = 1e-9  # of the largest coefficient: condition of the normal equations at n = 2 sqrt(N) times rounding
RATE = 1000.0
DERIVE = 5.0  # times a Butterworth filter and two gradients


def timed(action: Callable[[], Result], rounds: int) -> tuple[float, Result]:
    """The least processor time of several runs, which a busy machine does not lengthen by much, and the last result."""
    least = np.inf
    for _ in range(rounds):
        start = time.process_time()
        found = action()
        least = min(least, time.process_time() - start)
    return least, found


def seconds(action: Callable[[], object], rounds: int) -> float:
    return timed(action, rounds)[0]


def motion(samples: int) -> tuple[Array, Array]:
    """Stamps and readings of an encoder, at 1 kHz."""
    t = np.arange(samples) / RATE
    return t, COARSE.measure(multisine(0, samples / RATE)(t)[0], 0)


def plan(t: Array, degree: int) -> Plan:
    return Plan("lsq", "chebyshev", degree, None, np.inf, degree / (np.pi * (t[-1] - t[0])))


def least_squares(quick: bool) -> None:
    print("1. least squares: ratios to chebfit")
    print(f"{'N':>8}{'n':>5}{'chebfit s':>11}{'first s':>9}{'again s':>9}{'uneven s':>9}   first  again uneven  target")
    for (samples, degree), target in TARGETS.items():
        if quick and samples * degree > 1e7:
            continue
        t, x = motion(samples)
        uneven = t + np.random.default_rng(0).uniform(-0.4, 0.4, samples) / RATE
        tau = 2 * (t - t[0]) / (t[-1] - t[0]) - 1
        theirs, expected = timed(lambda tau=tau, x=x, n=degree: chebyshev.chebfit(tau, x, n), 5 if samples < 1e5 else 1)
        found = Operator(t, plan(t, degree)).fit(x).coefficients[0, :, 0]
        assert np.max(np.abs(found - expected)) < EQUAL * np.max(np.abs(expected)), "results differ"

        def first(t: Array = t, x: Array = x, n: int = degree) -> None:
            _uniform_factors.cache_clear()
            Operator(t, plan(t, n)).fit(x)

        ours = [
            seconds(first, 10),
            seconds(lambda t=t, x=x, n=degree: Operator(t, plan(t, n)).fit(x), 10),
            seconds(lambda t=uneven, x=x, n=degree: Operator(t, plan(t, n)).fit(x), 5),
        ]
        print(
            f"{samples:8}{degree:5}{theirs:11.3g}{ours[0]:9.2g}{ours[1]:9.2g}{ours[2]:9.2g}   "
            + "".join(f"{theirs / mine:6.0f} " for mine in ours)
            + f"{target:7}"
        )


def _peak() -> float:
    """Largest resident size of this program so far, bytes (Linux); that of `resource` is its parent's at first."""
    status = Path("/proc/self/status").read_text()
    return 1024.0 * float(status.partition("VmHWM:")[2].split()[0])


def grow(kind: str, samples: int) -> None:
    """In a process of its own: print by how many bytes a projection made the process grow."""
    t = np.arange(samples) / RATE
    x = np.sin(t) + 1e-4 * np.random.default_rng(0).standard_normal(samples)
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    before = _peak()
    if kind == "lsq":
        Operator(t, plan(t, 632 if samples >= 1e5 else 200)).fit(x)
    else:
        found = project(t, x, Setting())
        for order in (0, 1, 2):
            found.at(t, order)
    print(_peak() - before)


def memory(quick: bool) -> None:
    print("\n2. memory: growth of the peak, MB (bytes per sample)")
    sizes = [10_000, 100_000, 1_000_000] + ([] if quick else [10_000_000])
    for kind, title in (("lsq", "least squares, n = 200 or 632"), ("derive", "derive, automatic")):
        cells = []
        for samples in sizes:
            command = [sys.executable, "-m", "tests.bench.speed", "--grow", kind, str(samples)]
            used = float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            cells.append(f"{samples:.0e}: {used / 1e6:.0f} ({used / samples:.0f})")
        print(f"{title:32}" + "   ".join(cells))


def derive(t: Array, x: Array, setting: Setting) -> list[Array]:
    found = project(t, x, setting)
    return [found.at(t, order) for order in (0, 1, 2)]


def butterworth(t: Array, x: Array) -> list[Array]:
    q = sosfiltfilt(butter(4, 10.0, fs=RATE, output="sos"), x)
    dq = np.gradient(q, t)
    return [q, dq, np.gradient(dq, t)]


def derivatives(samples: int = 1_000_000) -> None:
    print(f"\n3. position, velocity, acceleration of {samples:.0e} samples")
    t, x = motion(samples)
    theirs = seconds(lambda: butterworth(t, x), 5)
    print(f"{'Butterworth, two gradients':32}{theirs:7.3f} s")
    for title, setting in (("chebid, automatic", Setting()), ("chebid, lsq to 10 Hz", Setting("lsq", bandwidth=10.0))):
        mine = seconds(lambda setting=setting: derive(t, x, setting), 4)
        print(f"{title:32}{mine:7.3f} s: {mine / theirs:.2f} times (at most {DERIVE:g})")
    truth, end = multisine(0, samples / RATE)(t)[2], samples // 1000
    for title, found in (("Butterworth", butterworth(t, x)), ("chebid, automatic", derive(t, x, Setting()))):
        off = np.linalg.norm((found[2] - truth)[end:-end]) / np.linalg.norm(truth)
        print(f"   error of the accelerations, {title}: {100 * off:.2f} %")


def growth(quick: bool, plot: str | None) -> None:
    print("\n4. cost, s")
    sizes = [int(size) for size in np.geomspace(1e3, 1e6 if quick else 1e7, 7 if quick else 9)]
    signals = {size: motion(size) for size in sizes}
    kinds: dict[str, Callable[[Array, Array], object]] = {
        "least squares, n = 100": lambda t, x: Operator(t, plan(t, 100)).fit(x),
        "derive, automatic": lambda t, x: derive(t, x, Setting()),
        "Butterworth, two gradients": butterworth,
    }
    print(" " * 28 + "".join(f"{size:>9.0e}" for size in sizes) + "   exponent")
    times = {}
    for name, action in kinds.items():
        action(*signals[sizes[0]])
        cost = [seconds(lambda a=action, s=size: a(*signals[s]), 3 if size < 3e6 else 1) for size in sizes]
        large = np.array(sizes) >= 1e4  # below, a call costs what it costs
        exponent = np.polyfit(np.log(np.array(sizes)[large]), np.log(np.array(cost)[large]), 1)[0]
        print(f"{name:28}" + "".join(f"{one:9.2g}" for one in cost) + f"   {exponent:.2f}")
        times[name] = cost
    if plot:
        draw(plot, sizes, times)


def draw(path: str, sizes: list[int], times: dict[str, list[float]]) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.5, 4.5), layout="constrained")
    axes = figure.add_subplot()
    for name, cost in times.items():
        axes.loglog(sizes, cost, "o-", markersize=4, label=name)
    reference = np.array(sizes) * np.log(sizes)
    axes.loglog(sizes, 0.3 * times["derive, automatic"][-1] * reference / reference[-1], "k:", label="N log N")
    axes.set_xlabel("samples")
    axes.set_ylabel("time [s], one thread")
    axes.grid(True, which="major", alpha=0.3)
    axes.legend()
    figure.savefig(path)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--plot", metavar="FILE")
    parser.add_argument("--grow", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.grow:
        grow(given.grow[0], int(given.grow[1]))
        return
    least_squares(given.quick)
    memory(given.quick)
    derivatives()
    growth(given.quick, given.plot)


if __name__ == "__main__":
    main()
