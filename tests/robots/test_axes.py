"""Independent axes: one inertia each, with the units of the kind of joint."""

import numpy as np
from arms import make_model

from chebid.dynamics import make_dynamics
from chebid.effects import Motion
from chebid.robots import Axes, make_robot


def test_acceleration_on_the_diagonal():
    ddq = np.array([[1.0, -2.0, 3.0], [4.0, 5.0, -6.0]])
    regressor = Axes(("a", "b", "c"), ("revolute",) * 3).regressor(np.zeros((2, 3)), np.zeros((2, 3)), ddq)
    np.testing.assert_array_equal(regressor[0], np.diag([1.0, -2.0, 3.0]))
    np.testing.assert_array_equal(regressor[1], np.diag([4.0, 5.0, -6.0]))


def test_names_and_units_follow_the_kind_of_joint():
    data = {
        "robot": {"type": "axes", "types": ["prismatic", "revolute"]},
        "joints": ["x", "wheel"],
        "effects": ["viscous", "coulomb", "offset", "viscous_asymmetry"],
    }
    found = [(p.name, p.joint, p.unit) for p in make_dynamics(make_model(data)).parameters]
    forces = [("M1", "kg"), ("Fv1", "N.s/m"), ("Fs1", "N"), ("Foff1", "N"), ("dFv1", "N.s/m")]
    torques = [("J2", "kg.m^2"), ("Fv2", "N.m.s/rad"), ("Fs2", "N.m"), ("Foff2", "N.m"), ("dFv2", "N.m.s/rad")]
    assert found == [(n, "x", u) for n, u in forces] + [(n, "wheel", u) for n, u in torques]


def test_without_types_axes_turn():
    robot = make_robot(make_model({"robot": {"type": "axes"}, "joints": ["a", "b"]}))
    assert robot.rotary == (True, True)


def test_friction_acts_on_its_own_joint_only():
    data = {"robot": {"type": "axes"}, "joints": ["a", "b"], "effects": [{"effect": "coulomb", "joint": "b"}]}
    dynamics = make_dynamics(make_model(data))
    still = np.zeros((1, 2))
    regressor = dynamics.regressor(Motion(np.zeros(1), still, np.array([[3.0, -2.0]]), still))[0]
    assert [p.name for p in dynamics.parameters] == ["J1", "J2", "Fs2"]
    np.testing.assert_array_equal(regressor, [[0, 0, 0], [0, 0, -1]])
