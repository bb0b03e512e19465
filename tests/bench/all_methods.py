"""How long does --method all take on the 8 s record, once chebid has started? python -m tests.bench.all_methods

Prints the ratio to importing numpy and to the time of `chebid --help`, both as a shell would wait for them: the machine
counts little.
"""

import contextlib
import io
import os
import subprocess
import sys
import time
from pathlib import Path

os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1"))
ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "workflow" / "scripts")]
HELP = "import sys; from chebid.cli import main; sys.argv = ['chebid', '--help']; main()"
REPEATS = 3
MOVES = 9
DURATION = 8.14


def shell(*arguments: str) -> float:
    """s that a command takes, the best of some."""

    def once() -> float:
        start = time.perf_counter()
        subprocess.run([sys.executable, *arguments], check=True, capture_output=True, cwd=ROOT)
        return time.perf_counter() - start

    return min(once() for _ in range(REPEATS))


def main() -> None:
    import numpy as np
    from study import estimates, records, with_prior

    from chebid.estimators import METHODS, Problem
    from chebid.excite.limits import make_limits
    from chebid.excite.points import Points
    from chebid.model import read_model
    from chebid.simulate import Reference

    model = read_model(ROOT / "config" / "scara.yaml")
    family = Points(make_limits(model), DURATION, MOVES)
    t = np.linspace(0, DURATION, round(200 * DURATION) + 1)
    motion = Reference(t, *family.motion(family.random(np.random.default_rng(0)), t))
    (log,) = records(model, motion, [0], rate=100.0)
    best: dict[str, float] = {}
    for _ in range(REPEATS):
        with contextlib.redirect_stderr(io.StringIO()):
            problem = Problem(with_prior(model, 0.3, 0), (log,))
            for method, _, seconds in estimates(problem, list(METHODS)):
                best[method] = min(best.get(method, np.inf), seconds)
    total = sum(best.values())
    numpy, help_ = shell("-c", "import numpy"), shell("-c", HELP)
    for method, seconds in best.items():
        print(f"{method:>6} {seconds:7.3f} s")
    print(f"{'all':>6} {total:7.3f} s; {total / help_:.1f} x chebid --help, {total / numpy:.1f} x import numpy")


if __name__ == "__main__":
    main()
