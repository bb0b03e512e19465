"""A chain in a simulation: mass matrix and bias of a tree of bodies, compiled.

The recursive Newton-Euler equations (Featherstone, Rigid Body Dynamics Algorithms, 2008, table 5.1) as
`robots.chain` has them, with numbers in the place of columns: once for the bias, once for every unit of acceleration.
"""

import numpy as np
from numba import njit

from chebid.robots import Array, Chain
from chebid.simulate.compiling import PLANT, jit

_BODY = 29  # numbers of a body: parent, rotation, origin, turn, slide, its ten parameters


def tree_data(robot: Chain, values: Array) -> Array:
    """What `tree` needs to know of a chain with base parameters `values` (P,): those left out are zero."""
    parameters = np.zeros(10 * len(robot.joints))
    parameters[list(robot.base[0])] = values
    t = robot.tree
    rows = [
        np.concatenate([[t.parent[i]], t.rotation[i].ravel(), t.origin[i], t.turn[i], t.slide[i], own])
        for i, own in enumerate(parameters.reshape(-1, 10))
    ]
    return np.concatenate([t.gravity, *rows])


@jit
def _cross_add(a, b, out):  # type: ignore[no-untyped-def]
    """out += a x b."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@jit
def _pose(x, b, R, o):  # type: ignore[no-untyped-def]
    """Rotation R (3, 3) and origin o (3,) of a body b (29,) in its parent's frame, its joint at x."""
    u, s = b[13:16], b[16:19]
    turns = u[0] != 0.0 or u[1] != 0.0 or u[2] != 0.0
    sine, versed = (np.sin(x), 1.0 - np.cos(x)) if turns else (0.0, 0.0)
    T = np.empty((3, 3))
    for i in range(3):
        for k in range(3):  # u is a unit vector: W W = u u^T - 1
            T[i, k] = versed * u[i] * u[k] + (1.0 - versed if i == k else 0.0)
    T[0, 1] -= sine * u[2]
    T[0, 2] += sine * u[1]
    T[1, 0] += sine * u[2]
    T[1, 2] -= sine * u[0]
    T[2, 0] -= sine * u[1]
    T[2, 1] += sine * u[0]
    way = np.zeros(3)
    if turns:
        _cross_add(u, s, way)  # from the origin to the axis; it stays where it is
        arm = way.copy()
        for i in range(3):
            for k in range(3):
                way[i] -= T[i, k] * arm[k]
    else:
        for i in range(3):
            way[i] = x * s[i]
            for k in range(3):
                T[i, k] = 1.0 if i == k else 0.0
    for i in range(3):
        o[i] = b[10 + i]
        for k in range(3):
            o[i] += b[1 + 3 * i + k] * way[k]
            R[i, k] = 0.0
            for m in range(3):
                R[i, k] += b[1 + 3 * i + m] * T[m, k]


@jit
def _turned_back(R, x, out):  # type: ignore[no-untyped-def]
    """out = R^T x."""
    for i in range(3):
        out[i] = R[0, i] * x[0] + R[1, i] * x[1] + R[2, i] * x[2]


@jit
def _inverse(poses, origins, dq, ddq, gravity, bodies, torque):  # type: ignore[no-untyped-def]
    """Torque (J,) of a motion; poses (J, 3, 3) and origins (J, 3) are known."""
    J = len(dq)
    states, spare = np.zeros((6, J, 3)), np.empty((4, 3))
    w, v, dw, dv, force, moment = states[0], states[1], states[2], states[3], states[4], states[5]
    a, b, c, d = spare[0], spare[1], spare[2], spare[3]
    for i in range(J):
        body, R, o = bodies[i], poses[i], origins[i]
        up = int(body[0])
        for k in range(3):
            a[k] = w[up, k] if up >= 0 else 0.0
            b[k] = v[up, k] if up >= 0 else 0.0
            c[k] = dw[up, k] if up >= 0 else 0.0
            d[k] = dv[up, k] if up >= 0 else -gravity[k]
        _cross_add(a, o, b)
        _cross_add(c, o, d)
        _turned_back(R, a, w[i])
        _turned_back(R, b, v[i])
        _turned_back(R, c, dw[i])
        _turned_back(R, d, dv[i])
        for k in range(3):
            a[k], b[k] = body[13 + k] * dq[i], body[16 + k] * dq[i]
            w[i, k] += a[k]
            v[i, k] += b[k]
            dw[i, k] += body[13 + k] * ddq[i]
            dv[i, k] += body[16 + k] * ddq[i]
        _cross_add(w[i], a, dw[i])
        _cross_add(w[i], b, dv[i])
        _cross_add(v[i], a, dv[i])
        xx, xy, xz, yy, yz, zz = body[19], body[20], body[21], body[22], body[23], body[24]
        first, mass = body[25:28], body[28]
        for k in range(3):
            a[k] = dv[i, k]
        _cross_add(w[i], v[i], a)  # acceleration of the origin
        for k in range(3):
            b[k], c[k], force[i, k] = 0.0, 0.0, mass * a[k]
        _cross_add(w[i], first, b)
        _cross_add(w[i], b, force[i])
        _cross_add(dw[i], first, force[i])
        x, y, z = w[i, 0], w[i, 1], w[i, 2]
        c[0], c[1], c[2] = xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z
        x, y, z = dw[i, 0], dw[i, 1], dw[i, 2]
        moment[i, 0] = xx * x + xy * y + xz * z
        moment[i, 1] = xy * x + yy * y + yz * z
        moment[i, 2] = xz * x + yz * y + zz * z
        _cross_add(w[i], c, moment[i])
        _cross_add(first, a, moment[i])
    for i in range(J - 1, -1, -1):
        body, R, o = bodies[i], poses[i], origins[i]
        up = int(body[0])
        torque[i] = 0.0
        for k in range(3):
            torque[i] += body[16 + k] * force[i, k] + body[13 + k] * moment[i, k]
        if up >= 0:
            for k in range(3):
                a[k] = R[k, 0] * force[i, 0] + R[k, 1] * force[i, 1] + R[k, 2] * force[i, 2]
                b[k] = R[k, 0] * moment[i, 0] + R[k, 1] * moment[i, 1] + R[k, 2] * moment[i, 2]
            _cross_add(o, a, b)
            for k in range(3):
                force[up, k] += a[k]
                moment[up, k] += b[k]


@njit(PLANT, cache=True)
def tree(q, dq, p, mass, bias):  # type: ignore[no-untyped-def]
    """p of `tree_data`."""
    J = len(q)
    bodies = p[3:].reshape((J, _BODY))
    poses, origins = np.empty((J, 3, 3)), np.empty((J, 3))
    for i in range(J):
        _pose(q[i], bodies[i], poses[i], origins[i])
    unit, still, column = np.zeros(J), np.zeros(J), np.empty(J)
    _inverse(poses, origins, dq, still, p[:3], bodies, bias)
    for j in range(J):
        unit[j] = 1.0
        _inverse(poses, origins, still, unit, np.zeros(3), bodies, column)
        unit[j] = 0.0
        for i in range(J):
            mass[i, j] = column[i]
