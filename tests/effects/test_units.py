"""Units: the same motion written in other units gives the same torque, if parameters change as their units say."""

import re

import numpy as np
import pytest
from effects.motions import SCARA, STAGE, all_of, known, label, smooth
from hypothesis import given
from hypothesis import strategies as st

from chebid.dynamics import Dynamics
from chebid.effects import LIBRARY, Motion, Units
from chebid.robots import Axes

# as powers of (time, position, torque): kg.m^2 is N.m.s^2/rad, kg is N.s^2/m; N.m and rad are units of their own
BASE = {"s": (1, 0, 0), "rad": (0, 1, 0), "m": (0, 1, 0), "N.m": (0, 0, 1), "N": (0, 0, 1), "1": (0, 0, 0)}
WHOLE = {"kg.m^2": (2, -1, 1), "kg": (2, -1, 1), "1/rev": (0, -1, 0), "rad/m": (0, -1, 0)}


def powers(unit: str) -> np.ndarray:
    """Powers of time, position and torque in a unit."""
    if unit in WHOLE:
        return np.array(WHOLE[unit], dtype=float)
    above, _, below = unit.partition("/")
    out = np.zeros(3)
    for side, part in ((1, above), (-1, below.strip("()"))):
        for token, exponent in re.findall(r"(N\.m(?![a-z])|[A-Za-z]+|1(?!.))(?:\^([0-9.]*[0-9]))?", part):
            out += side * np.array(BASE[token]) * float(exponent or 1)
    return out


@pytest.mark.parametrize(
    ("unit", "wanted"),
    [
        ("N.m.s/rad", (1, -1, 1)),
        ("N.s^2/m^2", (2, -2, 1)),
        ("N.m.s^0.5/rad^0.5", (0.5, -0.5, 1)),
        ("rad/(N.m)", (0, 1, -1)),
    ],
)
def test_powers(unit, wanted):
    assert tuple(powers(unit)) == wanted


# seen through trigonometry or a robot with lengths of its own: no other unit of angle
ANGLES = {"base_tilt"}


def rescaled(motion: Motion, time: float, position: float, torque: float) -> Motion:
    mass = torque * time**2 / position
    state = motion.q * position, motion.dq * position / time, motion.ddq * position / time**2
    return Motion(motion.t * time, *state, motion.tau * torque, motion.rigid * mass)


@given(
    time=st.floats(0.2, 5), position=st.floats(0.2, 5), torque=st.floats(0.1, 10), kind=st.sampled_from(sorted(LIBRARY))
)
def test_scale_laws(time, position, torque, kind):
    robot = Axes(("x", "y"), ("prismatic", "prismatic"))
    motion = known(smooth(2, count=400), robot)
    other, scale, units = rescaled(motion, time, position, torque), np.array([time, position, torque]), Units(False)
    for effect in all_of(motion, robot):
        if effect.name != kind or kind in ANGLES:
            continue
        hypers = effect.hypers()
        changed = {
            name: value * np.prod(scale ** powers(units.named(hypers[name].unit)))
            if hypers[name].continuous and value is not None
            else value
            for name, value in effect.hyper.items()
        }
        twin = type(effect)(effect.joint, **changed).bind(robot)
        per = [np.prod(scale ** (np.array([0, 0, 1]) - powers(unit))) for unit in effect.units(units)]
        wanted = effect.block(motion) * np.array(per)
        size = np.abs(wanted).max(initial=1e-300)
        # the elastic columns are differences over a small distance, good to about 1e-7
        assert np.abs(twin.block(other) - wanted).max(initial=0.0) <= 1e-6 * size, label(effect)


@pytest.mark.parametrize("robot", [SCARA, STAGE], ids=["rotary", "mixed"])
def test_every_parameter_has_a_name_of_its_own_and_a_unit(robot):
    motion = known(smooth(2, count=200), robot)
    effects = []
    for kind in LIBRARY.values():
        for joint in [None] if kind.whole_arm else [0, 1]:
            effects += kind.candidates(motion, joint)[:1]
    parameters = Dynamics(robot, tuple(effects)).parameters
    names = [p.name for p in parameters]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name) for name in names)
    for p in parameters:
        powers(p.unit)  # a unit that this test can read
        assert p.joint in (*robot.joints, None)


def test_names_on_twelve_joints_differ():
    robot = Axes(tuple(f"j{i}" for i in range(12)), ("revolute",) * 12)
    motion = known(smooth(2, count=60, joints=12), robot)
    kinds = [kind for kind in LIBRARY.values() if not kind.whole_arm]
    effects = tuple(
        effect
        for kind in kinds
        for joint in range(12)
        for effect in (
            kind.candidates(motion, joint) if "source" in kind.hypers() else kind.candidates(motion, joint)[:1]
        )
        if getattr(effect, "ratio", 1) == 1
    )
    groups = Dynamics(robot, effects)._groups
    names = [p.name for group in groups for p in group]
    assert len(set(names)) == len(names)
    assert not any("." in name for name in names)  # no name had to be changed


def test_units_of_a_sliding_joint():
    units = Units(False)
    assert (units.position, units.velocity, units.torque, units.inertia) == ("m", "m/s", "N", "kg")
    assert (units.wave, units.compliance, units.per_position(1.5)) == ("rad/m", "m/N", "N/m^1.5")
    assert units.named("s") == "s"
