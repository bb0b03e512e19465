"""Eq. 18 (corrected) and 19: the numbers of the reference sheet, a recursive Newton-Euler, and laws of mechanics."""

import numpy as np
import pytest
from arms import JOINTS, NAMES, THETA, make_model, multisine, planar_torque
from hypothesis import given
from hypothesis import strategies as st

from chebid.dynamics import make_dynamics
from chebid.effects import Motion
from chebid.robots import Scara

SCARA = Scara(JOINTS)
Q, DQ, DDQ = np.array([[0.3, -0.7]]), np.array([[1.2, -0.4]]), np.array([[-2.0, 3.0]])
# in the order of the paper: ZZR1 Fv1 Fs1 ZZ2 LMX2 LMY2 Fv2 Fs2
ROW_1 = [-2, 1.2, 1, 1, -1.280216337074641, -0.0323439374101, 0, 0]
ROW_2 = [0, 0, 0, 1, -2.457357844191252, -0.187062624785719, -0.4, -1]

angle = st.floats(-4, 4)
speed = st.floats(-10, 10)
inertial = st.lists(st.floats(-2, 2), min_size=4, max_size=4).map(np.array)


def rigid_torque(q, dq, ddq, theta):
    one = [np.array([x], dtype=float) for x in (q, dq, ddq)]
    return (SCARA.regressor(*one) @ theta)[0]


def test_order_and_names_are_those_of_the_paper():
    parameters = make_dynamics(make_model()).parameters
    assert tuple(p.name for p in parameters) == NAMES
    assert [p.joint for p in parameters] == ["q1"] * 3 + ["q2"] * 5
    units = ["kg.m^2", "N.m.s/rad", "N.m"]
    assert [p.unit for p in parameters] == [*units, *["kg.m^2"] * 3, *units[1:]]


def test_reference_numbers():
    regressor = make_dynamics(make_model()).regressor(Motion(np.zeros(1), Q, DQ, DDQ))[0]
    np.testing.assert_allclose(regressor, [ROW_1, ROW_2], rtol=0, atol=1e-14)  # some ten roundings of numbers near 2


def test_reference_torques():
    torque = make_dynamics(make_model()).torque(Motion(np.zeros(1), Q, DQ, DDQ), THETA)[0]
    np.testing.assert_allclose(torque, [-6.16200558, -0.38000887], rtol=0, atol=5e-9)  # printed to eight decimals


@pytest.mark.parametrize("seed", range(5))
def test_newton_euler_agrees(seed):
    path = multisine(seed, duration=3.0, amplitude=2.0)
    theta = THETA * np.random.default_rng(seed).uniform(0.5, 2, 8)
    torque = make_dynamics(make_model()).torque(Motion(path.t, path.q, path.dq, path.ddq), theta)
    slow = planar_torque(path, theta)
    np.testing.assert_allclose(torque, slow, rtol=0, atol=1e-15 * 30 * np.abs(slow).max())  # some thirty operations


def test_a_batch_is_its_samples_one_by_one():
    path = multisine(1, duration=0.5)
    together = SCARA.regressor(path.q, path.dq, path.ddq)
    for i in range(len(path.t)):
        np.testing.assert_array_equal(together[[i]], SCARA.regressor(path.q[[i]], path.dq[[i]], path.ddq[[i]]))


@given(st.tuples(angle, angle), inertial)
def test_mass_matrix_is_symmetric(q, theta):
    columns = [rigid_torque(q, (0, 0), unit, theta) for unit in np.eye(2)]
    matrix = np.column_stack(columns)
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-14)


@given(st.tuples(angle, angle), st.tuples(speed, speed), st.tuples(speed, speed), inertial)
def test_power_of_the_joints_is_the_change_of_kinetic_energy(q, dq, ddq, theta):
    """d/dt (dq' M(q) dq / 2) = dq' tau: Coriolis terms of eq. 18 as printed in the paper violate it."""
    q, dq, ddq = np.array(q), np.array(dq), np.array(ddq)

    def energy(time):
        """Along q + dq t + ddq t^2 / 2, of complex time: its derivative is exact (complex step)."""
        at, rate = q + dq * time + ddq * time**2 / 2, dq + ddq * time
        zzr1, zz2, lmx2, lmy2 = theta
        coupling = lmx2 * np.cos(at[1]) - lmy2 * np.sin(at[1])
        both = rate[0] + rate[1]
        return zzr1 * rate[0] ** 2 / 2 + zz2 * both**2 / 2 + coupling * rate[0] * both

    change = energy(1e-30j).imag / 1e-30
    power = float(dq @ rigid_torque(q, dq, ddq, theta))
    scale = 1 + np.abs(dq).max() * (np.abs(ddq).max() + np.abs(dq).max() ** 2)
    assert power == pytest.approx(change, abs=1e-13 * scale)  # sums of some twenty terms of that size


@given(st.tuples(angle, angle), st.tuples(speed, speed), st.tuples(speed, speed), angle, inertial)
def test_turning_the_whole_arm_changes_nothing(q, dq, ddq, turn, theta):
    one, other = rigid_torque(q, dq, ddq, theta), rigid_torque((q[0] + turn, q[1]), dq, ddq, theta)
    np.testing.assert_array_equal(one, other)
