"""Is `poly`, left to itself, ever much worse than the best of the six? python tests/bench/methods.py [motions] [seeds]

Random fast motions of the SCARA of config/scara.yaml, 5 to 60 s, logs of 50 Hz to 1 kHz, two noise levels. Of every
motion: rmse of each method, relative to the best (the geometric mean over the parameters), and the worst ratio of
`poly`. `ekf` is left out: its prior tells it what the log does not. The last line is the verdict.
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
RIVALS = [method for method in METHODS if method != "ekf"]


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


def main() -> None:
    motions, seeds = (int(value) for value in (*sys.argv[1:], *("20", "8")[len(sys.argv) - 1 :]))
    model, random = read_model(ROOT / "config" / "scara.yaml"), np.random.default_rng(0)
    print(f"{'T':>5} {'rate':>5} {'noise':>5} " + " ".join(f"{method:>7}" for method in RIVALS) + "  worst of poly")
    verdict = 0.0
    for number in range(motions):
        reference = motion(model, random)
        rate = float(np.exp(random.uniform(np.log(50), np.log(1000))))
        name = list(NOISE)[number % 2]
        encoder, torque = NOISE[name]
        noisy = model.model_copy(update={"sensors": SensorsSection(encoder=encoder, torque_noise=torque)})
        found = {k: np.sqrt(np.mean(e**2, axis=0)) for k, e in errors(noisy, reference, rate, range(seeds)).items()}
        rivals = np.array([found[method] for method in RIVALS])
        means = {method: np.exp(np.mean(np.log(rmse))) for method, rmse in found.items()}
        best = min(means.values())
        worst = float(np.max(found["poly"] / rivals.min(axis=0)))
        verdict = max(verdict, means["poly"] / best)
        line = " ".join(f"{means[method] / best:7.2f}" for method in RIVALS)
        print(f"{reference.duration:5.1f} {rate:5.0f} {name:>5} {line}  {worst:.2f}", flush=True)
    print(f"poly: at most {verdict:.2f} times the best; wanted {MOST}")


if __name__ == "__main__":
    main()
