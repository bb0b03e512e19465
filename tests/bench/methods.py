"""Is `poly`, left to itself, ever much worse than the best? python tests/bench/methods.py [motions] [seeds] [draw]

Random fast motions of the SCARA of config/scara.yaml, 5 to 60 s, logs of 50 Hz to 1 kHz, two noise levels; `draw` other
motions than those of 0. Of every motion: rmse of each method, relative to the best (the geometric mean over the
parameters), and how sure that of `poly` is: the 5 % quantile of its ratio to each rival, the same seeds drawn again
for both (a rmse of 3 seeds is off by 40 %, and the best of several methods is the one that was lucky: 8 seeds at
least). `ekf` is left out: its prior tells it what the log does not; and `dr`, which is slow and the worst of the six
for nearly every parameter of figures/monte_carlo. The last lines are the verdict.
"""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "workflow" / "scripts")]

from study import estimates, records, with_prior  # noqa: E402

from chebid.errors import ChebidError  # noqa: E402
from chebid.estimators import METHODS, Problem  # noqa: E402
from chebid.excite.limits import make_limits  # noqa: E402
from chebid.excite.points import Points  # noqa: E402
from chebid.model import Model, read_model  # noqa: E402
from chebid.model.schema import SensorsSection  # noqa: E402
from chebid.results import fitted_values  # noqa: E402
from chebid.simulate import Reference  # noqa: E402

NOISE = {"low": (1.6e-4, (0.25, 0.025)), "high": (7.7e-4, (1.0, 0.1))}  # 15 and 13 bits per turn
MOST = 1.1
RIVALS = [method for method in METHODS if method not in ("ekf", "dr")]


def motion(model: Model, random: np.random.Generator) -> Reference:
    """A motion whose moves take about 0.9 s, sampled finely."""
    duration = float(np.exp(random.uniform(np.log(5), np.log(60))))
    family = Points(make_limits(model), duration, max(3, round(duration / 0.9)))
    t = np.linspace(0, duration, round(200 * duration) + 1)
    return Reference(t, *family.motion(family.random(random), t))


def errors(model: Model, reference: Reference, rate: float, seeds: range) -> dict[str, np.ndarray]:
    """Relative errors (seeds, P) of each method; infinite where it has no answer."""
    theta = fitted_values(model)
    out: dict[str, list[np.ndarray]] = {method: [] for method in RIVALS}
    fast = model.model_copy(
        update={"control": model.control.model_copy(update={"rate": max(500.0, rate)})}  # type: ignore[union-attr]
    )
    for seed, log in zip(seeds, records(fast, reference, seeds, rate=rate), strict=True):
        problem = Problem(with_prior(fast, 0.3, seed), (log,))
        for method, found, _ in estimates(problem, RIVALS):
            failed = isinstance(found, ChebidError)
            out[method].append(np.full(len(theta), np.inf) if failed else found.theta / theta - 1)
    return {method: np.array(values) for method, values in out.items()}


def size(errors: np.ndarray) -> np.ndarray:
    """Geometric mean over the parameters of the rmse over the seeds, of errors (..., seeds, P)."""
    return np.exp(np.mean(np.log(np.sqrt(np.mean(errors**2, axis=-2))), axis=-1))


def surely(errors: dict[str, np.ndarray]) -> float:
    """What `poly` is at least, with 95 %, times the rival that it is most surely worse than."""
    count = len(errors["poly"])
    drawn = np.random.default_rng(0).integers(0, count, (500, count))
    poly = size(errors["poly"][drawn])
    rivals = [size(e[drawn]) for name, e in errors.items() if name != "poly" and np.isfinite(e).all()]
    return max(float(np.quantile(poly / rival, 0.05)) for rival in rivals)


def main() -> None:
    motions, seeds, draw = (int(value) for value in (*sys.argv[1:], *("20", "8", "0")[len(sys.argv) - 1 :]))
    model, random = read_model(ROOT / "config" / "scara.yaml"), np.random.default_rng(draw)
    print(f"{'T':>5} {'rate':>5} {'noise':>5} " + " ".join(f"{method:>7}" for method in RIVALS) + "  surely")
    verdict, sure = [], []
    for number in range(motions):
        reference = motion(model, random)
        rate = float(np.exp(random.uniform(np.log(50), np.log(1000))))
        name = list(NOISE)[number % 2]
        encoder, torque = NOISE[name]
        noisy = model.model_copy(update={"sensors": SensorsSection(encoder=encoder, torque_noise=torque)})
        found = errors(noisy, reference, rate, range(seeds))
        means = {method: float(size(e)) for method, e in found.items()}
        best = min(means.values())
        verdict.append(means["poly"] / best)
        sure.append(surely(found))
        line = " ".join(f"{means[method] / best:7.2f}" for method in RIVALS)
        print(f"{reference.duration:5.1f} {rate:5.0f} {name:>5} {line}  {sure[-1]:6.2f}", flush=True)
    print(f"poly: at most {max(verdict):.2f} times the best, {np.median(verdict):.2f} in the median; wanted {MOST}")
    print(f"surely worse than {MOST} times a rival: {np.sum(np.array(sure) > MOST)} of {motions} motions")


if __name__ == "__main__":
    main()
