"""What the tests of the simulator share: models, references, and fits of known values."""

from typing import Any

import numpy as np

from chebid.dynamics import make_dynamics
from chebid.model import Model
from chebid.simulate import Options, Reference, Simulated, simulate

TRUE = {"ZZR1": 3.45, "Fv1": 0.03, "Fs1": 0.8, "ZZ2": 0.061, "LMX2": 0.124, "LMY2": 0.008, "Fv2": 0.012, "Fs2": 0.13}
CONTROL = {"kp": [1400.0, 60.0], "kd": [100.0, 2.6], "rate": 500.0}
QUIET = Options(noise="none")


def scara(effects: list[Any] | None = None, **sections: Any) -> Model:
    """The SCARA with perfect sensors unless given."""
    data = {
        "robot": {"type": "scara"},
        "joints": ["q1", "q2"],
        "effects": ["viscous", "coulomb"] if effects is None else effects,
        "control": CONTROL,
        "sensors": {},
    }
    return Model.model_validate(data | sections)


def slide(effects: list[Any], kp: float = 0.0, kd: float = 0.0, rate: float = 100.0, **sections: Any) -> Model:
    """One mass on a rail."""
    data = {
        "robot": {"type": "axes", "types": ["prismatic"]},
        "joints": ["x"],
        "effects": effects,
        "control": {"kp": kp, "kd": kd, "rate": rate},
        "sensors": {},
    }
    return Model.model_validate(data | sections)


def values(model: Model, **others: float) -> np.ndarray:
    """theta of a model, by name; those of the SCARA unless given, 0 for what is named nowhere."""
    known = TRUE | others
    return np.array([known.get(p.name, 0.0) for p in make_dynamics(model).parameters])


def waves(duration: float, rate: float = 100.0, size: tuple[float, ...] = (0.8, 1.2)) -> Reference:
    """Sines that start at rest, of joints that disagree."""
    t = np.arange(round(duration * rate) + 1) / rate
    w = np.array([2.9, 4.7, 3.7])[: len(size)]
    s, c = np.sin(w * t[:, None]), np.cos(w * t[:, None])
    return Reference(t, np.array(size) * s**3, np.array(size) * 3 * w * s**2 * c)


def coasting(speed: float, duration: float, rate: float = 100.0) -> Reference:
    """A reference that only gives the velocity to start with: the gains of such rigs are 0."""
    t = np.arange(round(duration * rate) + 1) / rate
    return Reference(t, speed * t[:, None], np.full((len(t), 1), speed))


def run(model: Model, theta: np.ndarray, reference: Reference, **options: Any) -> Simulated:
    """Without noise."""
    return simulate(model, theta, reference, options=Options(**({"noise": "none"} | options)))
