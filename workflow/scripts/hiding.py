"""Hidden effects: one drawn at random, sized, and written into a model file that `chebid simulate` can run."""

import copy
import itertools
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np
import yaml

from chebid.dynamics import make_dynamics
from chebid.effects import Motion
from chebid.model import per_joint, read_model
from chebid.results import fitted_values
from chebid.simulate import read_reference

NOTHING = "nothing"
_RESOLUTION = 0.02  # rad/s: slower samples do not count, as they would not in an identification
_SHOWS = 0.03  # of the torque of an effect at least, beside what friction and inertia take of it
Random = np.random.Generator
Draw = Callable[[Random], tuple[dict[str, Any], list[float]]]


def _plain(**ranges: tuple[float, float]) -> Draw:
    """One parameter, positive; hyper-parameters drawn uniformly."""
    return lambda random: ({name: random.uniform(*ends) for name, ends in ranges.items()}, [1.0])


def _signed(**ranges: tuple[float, float]) -> Draw:
    """One parameter of either sign."""
    way = _plain(**ranges)
    return lambda random: (way(random)[0], [float(random.choice([-1.0, 1.0]))])


def _waves(low: float, high: float) -> Draw:
    def draw(random: Random) -> tuple[dict[str, Any], list[float]]:
        phase = random.uniform(0, 2 * math.pi)
        return {"k": random.uniform(low, high)}, [math.cos(phase), math.sin(phase)]

    return draw


def _stribeck(random: Random) -> tuple[dict[str, Any], list[float]]:
    return {"vs": random.uniform(0.2, 0.6), "delta": float(random.choice([1.0, 2.0]))}, [1.0]


def _stop(random: Random) -> tuple[dict[str, Any], list[float]]:
    side = int(random.choice([-1, 1]))
    return {"qs": side * random.uniform(0.7, 1.0), "s": side, "m": float(random.choice([1.0, 1.5]))}, [1.0]


def _payload(random: Random) -> tuple[dict[str, Any], list[float]]:
    """A point mass taken up on the way, 0.4 m along a second link behind a first one of 0.5 m."""
    return {"t0": random.uniform(7, 13)}, [0.25, 0.16, 0.2, 0.0]


def _tilt(random: Random) -> tuple[dict[str, Any], list[float]]:
    way, share = random.uniform(0, 2 * math.pi), random.uniform(0.2, 0.5)
    first = [math.cos(way), math.sin(way)]
    return {}, [*first, *(share * part for part in first)]


#: name -> hyper-parameters and the direction of the parameters; the size follows from the strength
DRAWS: dict[str, Draw] = {
    "offset": _signed(),
    "viscous_asymmetry": _signed(),
    "stribeck": _stribeck,
    "viscous_quadratic": _plain(),
    "viscous_power": _plain(alpha=(0.3, 0.7)),
    "load_friction": _plain(),
    "presliding": _plain(delta=(0.01, 0.05)),
    "friction_ripple": _waves(3, 9),
    "torque_ripple": _waves(4, 12),
    "spring": lambda random: ({}, [1.0, random.uniform(-0.3, 0.3)]),
    "cubic_spring": _plain(q0=(-0.3, 0.3)),
    "hard_stop": _stop,
    "rotor_inertia": _plain(),
    "joint_flexibility": _plain(),
    "backlash": _plain(soft=(0.05, 0.1)),
    "viscous_coupling": _signed(),
    "coulomb_coupling": _signed(),
    "coulomb_drift": _plain(T=(3, 9)),
    "viscous_drift": _plain(T=(3, 9)),
    "payload": _payload,
    "base_tilt": _tilt,
    "external_push": _signed(t0=(6, 14), width=(0.5, 2)),
    "torque_delay": _plain(),
    "torque_gain": _signed(),
}
WHOLE_ARM = ("payload", "base_tilt", "torque_delay")
ON_LAST = ("rotor_inertia", "torque_gain")  # of the first joint it is part of the inertia, of the whole arm


def case_name(effect: str, strength: float, motion: str, noise: str, number: int) -> str:
    return f"{effect}-{strength:g}-{motion}-{noise}-{number}"


def cases(own: dict[str, Any]) -> list[str]:
    """Names of the logs of a study (section `hidden`); everything random about a log follows from its name.

    Each effect and strength gets `each` of the kinds of motion and noise, in turn, so that all occur equally often.
    """
    kinds = list(itertools.product(own["motions"], own["noises"]))
    out = []
    for i, (effect, strength) in enumerate(itertools.product(own["effects"], own["strengths"])):
        for k in range(own["each"]):
            out.append(case_name(effect, strength, *kinds[(i + k) % len(kinds)], k // len(kinds)))
    return out + [case_name(NOTHING, 0, *kinds[k % len(kinds)], k // len(kinds)) for k in range(own["nothing"])]


def motions_of(case: str, own: dict[str, Any]) -> list[str]:
    """Names of the motions of a case: that of its log, and one of another kind for the hold-out."""
    kind = case.split("-")[2]
    kinds = [kind, *(other for other in own["motions"] if other != kind)]
    return [f"motion_{name}_{(seed_of(case) >> 8 * i) % own['pool']}" for i, name in enumerate(kinds[:2])]


def seed_of(case: str) -> int:
    return crc32(case.encode())


def hidden_model(case: str, source: Path, motion: Path, out: Path) -> dict[str, Any]:
    """Write the model file of a case: another specimen of the arm of `source`, an effect of that strength in it.

    The strength is that along `motion` (see `strength`). Returns the truth: effect, joint, settings, values.
    """
    random = np.random.default_rng(seed_of(case))
    effect, size = case.split("-")[:2]
    content = yaml.safe_load(source.read_text(encoding="utf-8"))
    values = content["fit"]["parameters"]
    for entry in values.values():
        entry["value"] = round(entry["value"] * float(random.uniform(0.8, 1.25)), 5)
    if effect == NOTHING:
        _write(content, out)
        return {"effect": NOTHING, "joint": None, "settings": {}, "values": {}, "strength": 0.0}
    return _hide(effect, float(size), content, random, motion, out)


def _hide(effect: str, size: float, content: dict[str, Any], random: Random, motion: Path, out: Path) -> dict[str, Any]:
    for _ in range(50):
        grown = copy.deepcopy(content)
        told, direction = _entry(effect, grown["joints"], random)
        grown["effects"].append(told)
        names = _grow(grown, direction, out)
        unit = strength(out, motion, shows=_SHOWS)
        if unit is not None:
            break  # else this motion does not show it: a push while the joint rests, for instance
    assert unit is not None, f"{effect} never shows on {motion}"
    values = grown["fit"]["parameters"]
    for name, part in zip(names, direction, strict=True):
        values[name]["value"] = float(f"{size / unit * part:.5g}")
    if effect in ("friction_ripple", "presliding"):  # dry friction is nowhere negative
        level = values[f"Fs{grown['joints'].index(told['joint']) + 1}"]
        level["value"] = round(level["value"] + size / unit, 5)
    _write(grown, out)
    return _truth(told, {name: values[name]["value"] for name in names}, size)


def _entry(effect: str, joints: list[str], random: Random) -> tuple[dict[str, Any], list[float]]:
    joint = joints[-1] if effect in ON_LAST else joints[random.integers(len(joints))]
    settings, direction = DRAWS[effect](random)
    return {"effect": effect} | ({} if effect in WHOLE_ARM else {"joint": joint}) | _rounded(settings), direction


def _truth(entry: dict[str, Any], values: dict[str, float], size: float) -> dict[str, Any]:
    settings = {name: value for name, value in entry.items() if name not in ("effect", "joint")}
    told = {"effect": entry["effect"], "joint": entry.get("joint"), "settings": settings, "values": values}
    return told | {"strength": size}


def _grow(content: dict[str, Any], direction: list[float], out: Path) -> list[str]:
    """Give the new effect its parameters, of the size of `direction`; their names."""
    fit = content.pop("fit")
    known = fit["parameters"]
    _write(content, out)
    new = [p for p in make_dynamics(read_model(out)).parameters if p.name not in known]
    assert len(new) == len(direction), [p.name for p in new]
    added = {
        p.name: {"value": part, "unit": p.unit} | ({"joint": p.joint} if p.joint else {})
        for p, part in zip(new, direction, strict=True)
    }
    content["fit"] = fit | {"parameters": known | added}
    _write(content, out)
    return list(added)


def strength(path: Path, motion: Path, shows: float = 0.0) -> float | None:
    """rms torque that rigid links, viscous and Coulomb friction cannot explain, over the torque noise.

    Of the joint where it is largest, along the commanded motion. None if that is less than the fraction `shows` of
    the effect's torque.
    """
    model = read_model(path)
    plain = model.model_copy(update={"effects": model.effects[:2]})  # viscous, coulomb
    dynamics, base = make_dynamics(model), make_dynamics(plain)
    reference = read_reference(motion, model)
    along = Motion(reference.t, reference.q, reference.dq, reference.ddq)
    dq = reference.dq
    theta = fitted_values(model)
    known = np.array([dynamics.named(theta)[p.name] for p in base.parameters])
    extra = dynamics.torque(along, theta) - base.torque(along, known)
    noise = np.array(per_joint(model.sensors.torque_noise, len(model.joints)))
    moving = np.abs(dq) > _RESOLUTION
    columns = base.regressor(along)[moving] / np.broadcast_to(noise, dq.shape)[moving][:, None]
    wanted = np.where(moving, extra / noise, 0.0)
    left = np.zeros_like(dq)
    left[moving] = wanted[moving] - columns @ np.linalg.lstsq(columns, wanted[moving], rcond=None)[0]
    whole, found = (float(np.sqrt((x**2).sum(axis=0) / moving.sum(axis=0)).max()) for x in (extra / noise, left))
    return found if found >= shows * whole else None


def _rounded(settings: dict[str, Any]) -> dict[str, Any]:
    return {name: round(value, 4) if isinstance(value, float) else value for name, value in settings.items()}


def _write(content: dict[str, Any], out: Path) -> None:
    out.write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")
