"""The pitfalls, each as it is seen and as chebid answers it: monte_carlo_cases.py SETTINGS SHORT LONG EQ23 OUT.csv.

The motions are tables of find_motion; SETTINGS is JSON with the sections `scara` and `monte_carlo`.
"""

import argparse
import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.polynomial import Chebyshev
from study import records, reference

from chebid.basis import Array
from chebid.dynamics import make_dynamics
from chebid.effects import Motion
from chebid.errors import ChebidError, NoAnswerError
from chebid.estimators import Problem, estimate
from chebid.files import write_with
from chebid.log import Log, LogSpec, Record
from chebid.model import Model, read_model
from chebid.model.schema import ControlSection, EffectSpec, ProcessingSection, RobotSection
from chebid.results import fitted_values
from chebid.simulate import Reference

COLUMNS = ["case", "variant", "seed", "parameter", "truth", "value", "sd", "sd_eq26", "warned"]
Found = tuple[Array, Array, Array, bool]  # theta, honest and white deviations, whether the pitfall was told


@dataclass(frozen=True)
class Bench:
    """The robot, its motions and the noise seeds."""

    model: Model
    short: Reference
    long: Reference
    eq23: Reference
    seeds: Sequence[int]

    @property
    def theta(self) -> Array:
        return fitted_values(self.model)


def set_(model: Model, **processing: object) -> Model:
    """The model, some of its processing set."""
    return model.model_copy(update={"processing": ProcessingSection.model_validate(processing)})


def chebid(model: Model, log: Log, kind: str = "", method: str = "poly") -> Found:
    """As chebid does it; `kind` of notice that counts as told, as a refusal does, which has no numbers."""
    problem = Problem(model, (log,))
    try:
        found = estimate(problem, method)
    except NoAnswerError as err:
        print(f"{log.path}: refused: {err}")
        nothing = np.full(len(problem.dynamics.parameters), np.nan)
        return nothing, nothing, nothing, True
    return found.theta, found.sd, found.sd_white, any(kind and kind in notice.kind for notice in found.notices)


def plain(model: Model, log: Log, *, gate: float = 0.0, cut: bool = False, weights: bool = True) -> Found:
    """Least squares on all samples: no projection of the equations; deviations by eq. 25."""
    problem = Problem(model, (log,))
    (track,) = problem.tracks
    used = (np.abs(track.motion.dq) >= gate) & (track.valid[:, None] if cut else True)
    return sample_by_sample(problem, track.motion, track.torque, used, weights)


def raw(model: Model, log: Log, degree: int) -> Found:
    """The same on a fit of numpy's that nobody has checked, to the ends, with one weight."""
    (record,) = log.records
    fits = [Chebyshev.fit(record.t, column, degree) for column in record.q.T]
    q, dq, ddq = (np.column_stack([fit.deriv(k)(record.t) if k else fit(record.t) for fit in fits]) for k in range(3))
    assert record.tau is not None
    used = np.ones(q.shape, dtype=bool)
    return sample_by_sample(Problem(model, (log,)), Motion(record.t, q, dq, ddq), record.tau, used, False)


def sample_by_sample(problem: Problem, motion: Motion, tau: Array, used: Array, weights: bool) -> Found:
    W = problem.dynamics.regressor(motion)
    size = np.ones(tau.shape[1])
    for _ in range(10):
        stacked, Y = (W / size[:, None])[used], (tau / size)[used]
        theta = np.linalg.lstsq(stacked, Y)[0]
        if weights:
            residual = tau - W @ theta
            size = np.array([residual[used[:, j], j].std() for j in range(len(size))])
    variance = np.sum((Y - stacked @ theta) ** 2) / (len(Y) - len(theta))
    sd = np.sqrt(variance * np.diag(np.linalg.inv(stacked.T @ stacked)))
    return theta, sd, sd, False


def early_torque(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """Torque logged at the command instant of a 100 Hz control: half a period early."""
    assert bench.model.control is not None
    slow = bench.model.control.model_copy(update={"rate": 100.0})
    model = bench.model.model_copy(update={"control": ControlSection.model_validate(slow.model_dump())})
    for seed, log in zip(bench.seeds, records(model, bench.short, bench.seeds, torque_log="command"), strict=True):
        first = estimate(Problem(model, (log,)), "poly")
        told = any(notice.kind == "torque_lag" for notice in first.notices)
        yield "as logged", seed, (first.theta, first.sd, first.sd_white, told)
        assert first.lag is not None
        yield "torque_delay as the warning says", seed, chebid(_delayed(model, first.lag.value), log, "torque_lag")
        yield "torque_delay: -0.005", seed, chebid(_delayed(model, -0.005), log, "torque_lag")


def _delayed(model: Model, delay: float) -> Model:
    return model.model_copy(update={"log": LogSpec(torque_delay=delay)})


def all_samples(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """n = 125 on the whole record, every sample to the ends, one weight."""
    for seed, log in zip(bench.seeds, records(bench.model, bench.short, bench.seeds), strict=True):
        yield "n = 125, all samples, one weight", seed, raw(bench.model, log, 125)
        yield "n = 125, asked of chebid", seed, chebid(set_(bench.model, fit="lsq", degree=125), log)
        yield "n = 110, chebid trims, gates, weights", seed, chebid(set_(bench.model, fit="lsq", degree=110), log)
        yield "chebid, automatic", seed, chebid(bench.model, log)


def no_gate(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """Half a second of rest at every point, where dry friction has any value."""
    motion = rests(bench.short, 0.5)
    for seed, log in zip(bench.seeds, records(bench.model, motion, bench.seeds), strict=True):
        yield "all samples", seed, plain(bench.model, log, cut=True)
        yield "samples with abs(dq) > 0.05", seed, plain(bench.model, log, cut=True, gate=0.05)
        yield "chebid, automatic", seed, chebid(bench.model, log)


def rests(motion: Reference, seconds: float) -> Reference:
    """The same motion with rests where all joints stop."""
    still = np.all(np.abs(motion.dq) < 1e-3 * np.abs(motion.dq).max(axis=0), axis=1)
    stops = np.flatnonzero(still[1:] & ~still[:-1]) + 1
    count = round(seconds * motion.rate)
    index = np.insert(np.arange(len(motion.t)), np.repeat(stops, count), np.repeat(stops, count))
    copies = np.zeros(len(index), dtype=bool)
    copies[1:] = np.diff(index) == 0
    quiet = np.where(copies[:, None], 0.0, 1.0)
    assert motion.ddq is not None
    t = np.arange(len(index)) / motion.rate
    return Reference(t, motion.q[index], quiet * motion.dq[index], quiet * motion.ddq[index])


def small_degree(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """A record of 20 s with a degree that would do for 8 s."""
    low = set_(bench.model, fit="lsq", degree=160)
    for seed, log in zip(bench.seeds, records(bench.model, bench.long, bench.seeds), strict=True):
        yield "n = 160, only q projected", seed, plain(low, log, cut=True, gate=0.05)
        yield "n = 160, the equation projected too", seed, chebid(low, log, "wide_band")
        yield "chebid, automatic", seed, chebid(bench.model, log)


def one_weight(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """The same weight for joints whose torque noises differ by 10."""
    for seed, log in zip(bench.seeds, records(bench.model, bench.short, bench.seeds), strict=True):
        yield "one weight", seed, plain(bench.model, log, cut=True, gate=0.05, weights=False)
        yield "a weight for each joint", seed, plain(bench.model, log, cut=True, gate=0.05)
        yield "chebid, automatic", seed, chebid(bench.model, log)


def criterion(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """The motion that minimises eq. 23, against one that minimises the deviations."""
    for variant, motion in (
        ("motion of least cond(W) + 1/sigma_min(W)", bench.eq23),
        ("of least deviations", bench.short),
    ):
        for seed, log in zip(bench.seeds, records(bench.model, motion, bench.seeds), strict=True):
            yield variant, seed, chebid(bench.model, log)


DUFFING = {"J1": 1.0, "Fv1": 2.0, "Fs1": 5.0, "k1": 400.0, "k31": 4000.0}
OSCILLATOR = Model(
    robot=RobotSection(type="axes"),
    joints=("q1",),
    effects=tuple(EffectSpec(effect=name) for name in ("viscous", "coulomb", "spring", "cubic_spring")),
)
RATE = 100.0


def duffing(bench: Bench) -> Iterator[tuple[str, int, Found]]:
    """A Duffing oscillator with dry friction under wide-band forces, the log at 100 Hz."""
    model = OSCILLATOR
    for kind in ("multisine to 3 Hz", "multisine to 20 Hz", "random force"):
        for seed in bench.seeds:
            log = oscillate(force(kind, seed), seed)
            for variant, used in (
                (f"{kind}, to 5 Hz", set_(model, bandwidth=5.0)),
                (f"{kind}, automatic", model),
            ):
                yield variant, seed, chebid(used, log, "wide_band")


def force(kind: str, seed: int, seconds: float = 20.0) -> Array:
    """At 10 kHz, N, of rms 20."""
    random, t = np.random.default_rng([seed, 7]), np.arange(round(seconds * 1e4)) / 1e4
    if kind == "random force":  # a new value 50 times a second
        return 20 * np.repeat(random.standard_normal(round(50 * seconds)), 200)
    highest = 3.0 if "3 Hz" in kind else 20.0
    f = np.arange(1, round(highest * seconds) + 1, 3) / seconds
    return (
        20 * np.sqrt(2 / len(f)) * np.cos(2 * np.pi * f * t[:, None] + random.uniform(0, 2 * np.pi, len(f))).sum(axis=1)
    )


def oscillate(u: Array, seed: int) -> Log:
    """Symplectic Euler at 0.1 ms with dry friction that sticks; log of position and mean force at 100 Hz."""
    J, Fv, Fs, k1, k3 = DUFFING.values()
    h, q, v = 1e-4, 0.0, 0.0
    out = np.empty(len(u))
    for i, now in enumerate(u.tolist()):
        out[i] = q
        free = v + h / J * (now - Fv * v - k1 * q - k3 * q**3)
        v = math.copysign(max(abs(free) - h * Fs / J, 0.0), free)
        q += h * v
    random, step = np.random.default_rng([seed, 8]), round(1e4 / RATE)
    mean = np.convolve(u, np.ones(step) / step, mode="same")[::step]
    position = np.round(out[::step] / 1e-5) * 1e-5
    t = np.arange(len(position)) / RATE
    tau = (mean + 0.1 * random.standard_normal(len(mean)))[:, None]
    return Log(Path(f"seed {seed}"), "", ("q1",), (Record(t, position[:, None], tau, None, np.arange(len(t)) + 2),), ())


CASES: dict[str, Callable[[Bench], Iterator[tuple[str, int, Found]]]] = {
    "torque logged early": early_torque,
    "untrimmed, unweighted": all_samples,
    "no gate": no_gate,
    "degree too small": small_degree,
    "one weight for all joints": one_weight,
    "motion": criterion,
    "wide band": duffing,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("settings", type=json.loads)
    parser.add_argument("motions", type=Path, nargs=3)
    parser.add_argument("out", type=Path)
    given = parser.parse_args()
    model = read_model(given.settings["scara"]["model"])
    motions = [reference(pd.read_csv(path), len(model.joints)) for path in given.motions]
    bench = Bench(model, *motions, range(given.settings["monte_carlo"]["cases"]))
    rows = []
    for case, run in CASES.items():
        names, truth = _truth(case, model)
        try:
            for variant, seed, (theta, sd, white, told) in run(bench):
                values = zip(names, truth, theta, sd, white, strict=True)
                rows += [(case, variant, seed, *numbers, int(told)) for numbers in values if numbers[1]]
        except ChebidError as err:
            print(f"{case}: {err}")
        print(case, flush=True)
    table = pd.DataFrame(rows, columns=COLUMNS)
    write_with(given.out, lambda beside: table.to_csv(beside, index=False), force=True)


def _truth(case: str, model: Model) -> tuple[list[str], list[float]]:
    if case == "wide band":
        names = [p.name for p in make_dynamics(OSCILLATOR).parameters]
        return names, [DUFFING.get(name, 0.0) for name in names]
    return [p.name for p in make_dynamics(model).parameters], list(fitted_values(model))


if __name__ == "__main__":
    main()
