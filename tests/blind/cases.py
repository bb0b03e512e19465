"""One random log with its hold-out: what is hidden in it, how it was taken, and the files chebid gets."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from blind import draw, faults
from blind.effects import KNOWN, UNKNOWN, Effect, Scene
from blind.friction import Offset, Presliding
from blind.motions import KINDS, Limits
from blind.motions import draw as draw_motion
from blind.strength import Trial, simulate, tune
from blind.world import Arm, Array, Log, Motion, Sensors, record, run

CATEGORIES = {"clean": 0.30, "one": 0.42, "two": 0.12, "unknown": 0.08, "fault": 0.08}
ASKED = (0.3, 0.5, 1.0, 2.0, 4.0)
RATES = (100.0, 200.0, 250.0, 500.0, 1000.0)


@dataclass(frozen=True)
class Taking:
    """How one log is taken."""

    kind: str
    motion: Motion
    duration: float


@dataclass
class Case:
    """Everything drawn for one row of the study, and the two logs."""

    category: str
    arm: Arm
    sensors: Sensors
    takings: tuple[Taking, Taking]
    noise_factor: float
    effects: list[Effect] = field(default_factory=list)
    asked: float = 0.0
    fault: str = ""
    plain: float = 0.0  # the ratio without any effect: what averaging and the timing of the torque column do
    dnr: float = 0.0
    slow: float = 0.0
    singles: list[float] = field(default_factory=list)
    logs: list[Log] = field(default_factory=list)


def make(seed: int, index: int, category: str | None = None, effect: str | None = None) -> Case:
    """The case of a seed and an index; what is drawn depends on nothing else. An arm that cannot follow is redrawn."""
    for attempt in range(20):
        rng = np.random.default_rng([seed, index, attempt])
        try:
            return _make(rng, category or str(rng.choice(list(CATEGORIES), p=list(CATEGORIES.values()))), effect)
        except FloatingPointError:
            continue
    raise RuntimeError(f"no arm of seed {seed}, index {index} follows its motion")


def _make(rng: np.random.Generator, category: str, wanted: str | None) -> Case:
    fault = str(rng.choice(list(faults.FAULTS))) if category == "fault" else ""
    arm, limits = (draw.scara if rng.random() < 0.7 else draw.axes)(rng)
    takings = _takings(limits, fault, rng)
    arm, plain = _with_friction(arm, takings[0], rng)
    load, factor = np.sqrt((plain.motor**2).mean(axis=0)), float(np.exp(rng.uniform(np.log(0.5), np.log(2.0))))
    noise = draw.NOISE * load * factor
    sensors = Sensors(
        float(rng.choice(RATES)),
        draw.counts(arm, limits, rng),
        tuple(noise.tolist()),
        float(rng.uniform(0.3, 0.9)) if rng.random() < 0.5 else 0.0,
        "command" if rng.random() < 0.25 else "mean",
        float(rng.choice([0.0, 0.5])),
    )
    if fault:
        arm, sensors = faults.prepare(fault, arm, sensors, plain, rng)
    case = Case(category, arm, sensors, takings, factor, fault=fault)
    scene = Scene(arm, plain, noise, (takings[0].duration, takings[1].duration))
    _hide(case, scene, rng, wanted)
    _take(case, noise, rng)
    return case


def _takings(limits: Limits, fault: str, rng: np.random.Generator) -> tuple[Taking, Taking]:
    """A motion to identify on and one of another kind to hold out."""
    kinds = [str(x) for x in rng.permutation(KINDS)[:2]]
    kinds[0] = faults.FAULTS[fault] or kinds[0] if fault else kinds[0]
    durations = [round(float(rng.uniform(10, 40)), 1), round(float(rng.uniform(10, 25)), 1)]
    if fault == "slow":
        limits = replace(limits, velocity=limits.velocity * 0.02, acceleration=limits.acceleration * 0.01)
    made = [Taking(k, draw_motion(k, limits, T, rng), T) for k, T in zip(kinds, durations, strict=True)]
    return made[0], made[1]


def _with_friction(arm: Arm, taking: Taking, rng: np.random.Generator) -> tuple[Arm, Any]:
    bare = run(arm, taking.motion, taking.duration)
    arm = draw.with_friction(arm, np.sqrt((bare.motor**2).mean(axis=0)), np.sqrt((bare.dq**2).mean(axis=0)), rng)
    return arm, run(arm, taking.motion, taking.duration)


def _hide(case: Case, scene: Scene, rng: np.random.Generator, wanted: str | None) -> None:
    """Draw the effects of the category and tune each on its own to an asked ratio."""
    if case.category in ("clean", "fault"):
        return
    choices = [kind for kind in (UNKNOWN if case.category == "unknown" else KNOWN) if case.arm.kind in kind.kinds]
    if wanted:
        choices = [kind for kind in (*KNOWN, *UNKNOWN) if kind.name == wanted and case.arm.kind in kind.kinds]
        if not choices:
            raise FloatingPointError(f"{wanted} needs another arm")
    for number in range(2 if case.category == "two" else 1):
        kind = choices[int(rng.integers(len(choices)))]
        asked = float(rng.choice(ASKED[2:] if case.category == "two" else ASKED))
        effect, got = _tuned(kind, asked, case, scene, rng)
        case.effects.append(effect)
        case.singles.append(got)
        case.asked = asked if not number else min(case.asked, asked)
        # a bristle replaces the dry friction that ripples and Stribeck's peak need
        lonely = Presliding in (kind, *choices) and kind is not Presliding and kind is not Offset
        choices = [c for c in choices if c.family != kind.family and not (lonely and c is Presliding)]


def _tuned(
    kind: type[Effect], asked: float, case: Case, scene: Scene, rng: np.random.Generator
) -> tuple[Effect, float]:
    effect = kind.draw(scene, int(rng.integers(case.arm.joints)), rng)
    first = case.takings[0]
    noise = np.array(case.sensors.noise)
    return tune(effect, asked, case.arm, first.motion, first.duration, case.sensors.rate, noise)


def _take(case: Case, noise: Array, rng: np.random.Generator) -> None:
    first, second = case.takings
    rate, mode = case.sensors.rate, case.sensors.torque
    case.plain = float(simulate(case.arm, [], first.motion, first.duration, rate, noise, mode).dnr.max())
    trial = simulate(case.arm, case.effects, first.motion, first.duration, rate, noise)
    case.dnr, case.slow = float(trial.dnr.max()), float(trial.slow.max())
    other = [effect for effect in (e.on_another_day() for e in case.effects) if effect is not None]
    held = simulate(case.arm, other, second.motion, second.duration, rate, noise)
    logs = [_log(t, case, taking, rng) for t, taking in ((trial, first), (held, second))]
    if case.fault:
        logs[0] = faults.spoil(case.fault, logs[0], rng)
    case.logs = logs


def _log(trial: Trial, case: Case, taking: Taking, rng: np.random.Generator) -> Log:
    return record(trial.outcome, case.sensors, taking.duration, rng, trial.reported)


def model_file(arm: Arm) -> str:
    """What a user writes first: the robot, viscous and Coulomb friction (JSON is YAML)."""
    robot: dict[str, Any] = {"type": arm.kind}
    if arm.kind == "axes":
        robot["types"] = ["prismatic" if slides else "revolute" for slides in arm.prismatic[: arm.joints]]
    joints = [f"q{j + 1}" for j in range(arm.joints)]
    return json.dumps({"robot": robot, "joints": joints, "effects": ["viscous", "coulomb"]})


def write(case: Case, folder: Path) -> Sequence[Path]:
    """model.yaml, log.csv and holdout.csv in the folder."""
    paths = [folder / name for name in ("model.yaml", "log.csv", "holdout.csv")]
    paths[0].write_text(model_file(case.arm))
    for path, log in zip(paths[1:], case.logs, strict=True):
        joints = range(1, case.arm.joints + 1)
        header = ",".join(["t", *(f"q{j}" for j in joints), *(f"tau{j}" for j in joints)])
        np.savetxt(path, np.column_stack([log.t, log.q, log.tau]), "%.10g", ",", header=header, comments="")
    return paths
