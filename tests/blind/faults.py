"""What preprocessing must survive: nothing is missing in these logs, and no effect may be called sure on them."""

from dataclasses import replace

import numpy as np
from blind.world import Arm, Log, Run, Sensors

# the motion that a fault needs, or "" for any
FAULTS: dict[str, str] = {
    "spikes": "", "seam": "", "held": "", "slow": "", "red_noise": "", "clipping": "moves", "wideband": "wideband",
    "coarse": "", "jerk": "trapezoid",
}  # fmt: skip


def prepare(fault: str, arm: Arm, sensors: Sensors, plain: Run, rng: np.random.Generator) -> tuple[Arm, Sensors]:
    """The arm and the sensors with the fault."""
    if fault == "red_noise":
        sensors = replace(sensors, colour=float(np.exp(-1 / (sensors.rate * rng.uniform(0.1, 0.5)))))
    if fault == "coarse":
        sensors = replace(sensors, encoder=tuple(count * 16 for count in sensors.encoder))
    if fault == "clipping":
        # the torque column says what acted: the motion suffers, the equations do not
        peak = np.percentile(np.abs(plain.motor), 99.9, axis=0)
        arm = replace(arm, limit=tuple((peak * rng.uniform(0.75, 0.9)).tolist()))
    return arm, sensors


def spoil(fault: str, log: Log, rng: np.random.Generator) -> Log:
    """The log with the fault."""
    make = {"spikes": _spikes, "seam": _seam, "held": _held}
    return make[fault](log, rng) if fault in make else log


def _spikes(log: Log, rng: np.random.Generator) -> Log:
    q = log.q.copy()
    for row in rng.choice(len(q), int(rng.integers(2, 9)), replace=False):
        q[row, rng.integers(q.shape[1])] += rng.choice([-1, 1]) * rng.uniform(0.01, 0.3) * np.ptp(q, axis=0).max()
    return replace(log, q=q)


def _seam(log: Log, rng: np.random.Generator) -> Log:
    """A stretch of 0.5 to 3 s cut out and the clock closed over it: two records joined end to end."""
    rate = 1 / (log.t[1] - log.t[0])
    gap = int(rng.uniform(0.5, 3.0) * rate)
    at = int(rng.uniform(0.3, 0.6) * len(log.t))
    keep = np.r_[0:at, at + gap : len(log.t)]
    return Log(log.t[: len(keep)], log.q[keep], log.tau[keep], log.clean[keep])


def _held(log: Log, rng: np.random.Generator) -> Log:
    """Positions that the bus did not refresh, for 2 to 6 samples each."""
    q = log.q.copy()
    for row in rng.choice(len(q) - 10, int(rng.integers(3, 20)), replace=False):
        q[row : row + int(rng.integers(2, 7))] = q[row]
    return replace(log, q=q)
