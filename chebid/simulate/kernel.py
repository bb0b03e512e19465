"""The compiled heart of the simulator: joint PD control, integration, and dry friction that really sticks.

Between two control instants the drive's torque u is constant (zero-order hold) and the motion is that of

    mass(q) ddq + bias(q, dq) + effects(t, q, dq) + friction = u.

Each joint with dry friction is in one of three modes: it slips forward (+1) or backward (-1), with friction
mode * level, or it sticks (0), with dq = 0 exactly and whatever friction up to the level holds it. Within a mode the
motion is smooth: classical Runge-Kutta steps of order 4, each compared with its two halves, which are kept; the
step is halved until they agree to the tolerance. A slipping joint that comes to rest, or a sticking one whose load
exceeds the level, ends the step there: the instant is found to rounding, and the modes of all joints at rest are
decided together, as the complementarity problem that couples them through the mass matrix (Acary and Brogliato,
Numerical Methods for Nonsmooth Dynamical Systems, 2008, chapters 3 and 9).

A joint whose link hangs on its motor by a spring or in a gap counts twice: the motor keeps its number, and has the
encoder, the drive and all effects; its link comes after the J joints. In what follows n is the number of both.

A state is an array (3, n) of q, dq, ddq. Arguments are few and plain: compiling time goes with their number.
"""

from typing import NamedTuple

import numpy as np
from numba import int64, njit, types

from chebid.effects.forward import bend
from chebid.simulate.compiling import FORWARD, PLANT, borrow, cube, indices, jit, many, matrix, table, vector

SLOTS = 32  # different effects in one simulation
FREE = 2  # mode of a joint without dry friction
# bits of an effect: dry friction; needs the model's torque; needs the acceleration; remembers its joint's last stop
DRY, LOADED, INERTIAL, REMEMBERS = 1, 2, 4, 8
MARGIN = 1e-12  # of all torques on a joint, by which its load must exceed the level for it to slip
OK, NOT_POSITIVE, NOT_FINITE, TOO_MANY_EVENTS, STEP_TOO_SMALL, NO_FIXED_POINT = 0, 1, 2, 3, 4, 5
_ITERATIONS = 100
_EVENTS = 300  # within one control period: a joint that turns and stops makes a few
_TRIES = 3000  # steps within one control period: usual are less than 50
_FAR = 1e9  # rad or m, and s: no motion

Q, V, A = 0, 1, 2  # rows of a state
# rows of the work space: torques of the drive, bias, effects that are not dry; level of dry friction; friction of
# joints at rest; dq on the right side of zero; torque of the model without the effects that need it; scratch
DRIVE, BIAS, EFFECT, LEVEL, HELD, SPEED, TAU, LOAD, BEFORE, STAGE = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9
SEEN, LAST = 14, 15  # encoders now and one control period before
LINK = 16  # number of each joint's link: its own, or from J on
STIFFNESS, DAMPING, GAP, ROTOR = 17, 18, 19, 20  # of transmissions; the last: what of a joint's inertia is its motor's
ROWS = 21
MASS, FACTOR, INVERSE = 0, 1, 2  # its squares
_ENGAGED = 0.01  # of a gap: so deep in contact its damper is whole, so that the force does not jump


class System(NamedTuple):
    """What moves, and arrays that every evaluation overwrites."""

    rigid: object  # fills mass and bias at (q, dq)
    p: object  # its data
    forward: object  # functions of the effects
    effects: object  # (3, E) which function, which joint, flags
    values: object  # (2, E, P) parameters, hyper-parameters
    loaded: bool  # whether an effect needs the model's torque
    arm: object  # (J + 3, J) the links' mass, q, dq, bias, where any hangs
    mode: object  # (n,)
    w: object  # (ROWS, n)
    square: object  # (3, n, n)


@jit
def _factorise(a, out):  # type: ignore[no-untyped-def]
    """Cholesky factor of a (J, J) into the lower half of out; False if a is not positive definite."""
    for i in range(len(a)):
        for j in range(i + 1):
            total = a[i, j]
            for k in range(j):
                total -= out[i, k] * out[j, k]
            if i != j:
                out[i, j] = total / out[j, j]
            elif total > 1e-14 * abs(a[i, i]):
                out[i, i] = np.sqrt(total)
            else:
                return False
    return True


@jit
def _substitute(factor, b, x):  # type: ignore[no-untyped-def]
    """Solve with the factor of `_factorise`."""
    n = len(b)
    for i in range(n):
        total = b[i]
        for k in range(i):
            total -= factor[i, k] * x[k]
        x[i] = total / factor[i, i]
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= factor[k, i] * x[k]
        x[i] = total / factor[i, i]


@jit
def _torque(s, e, t, q):  # type: ignore[no-untyped-def]
    """Torque (dry friction: level) of effect e at the acceleration in LOAD."""
    f = s.forward[s.effects[0, e]]
    return f(t, q, s.w[SPEED], s.w[LOAD], s.w[TAU], s.effects[1, e], s.values[0, e], s.values[1, e])


@jit
def _rigid(s, t, x):  # type: ignore[no-untyped-def]
    """Mass and bias, with the effects that are linear in the acceleration; velocities for the effects.

    Those never are on the wrong side of zero, so that a step that ends there stays smooth.
    """
    w, mass, n = s.w, s.square[MASS], len(s.mode)
    for j in range(n):
        sign = s.mode[j]
        w[SPEED, j] = x[V, j] if sign == FREE else (0.0 if sign == 0 else sign * max(sign * x[V, j], 1e-300))
        w[LOAD, j] = 0.0
    if n == s.arm.shape[1]:
        s.rigid(x[Q], x[V], s.p, mass, w[BIAS])
    else:
        _hanging(s, x)
    for e in range(s.effects.shape[1]):
        if s.effects[2, e] & INERTIAL:
            still = 0.0
            for i in range(-1, n):  # first without acceleration, then with one joint's at a time
                if i >= 0:
                    w[LOAD, i] = 1.0
                value = _torque(s, e, t, x[Q])
                if i >= 0:
                    mass[s.effects[1, e], i] += value - still
                    w[LOAD, i] = 0.0
                else:
                    still = value


@jit
def _hanging(s, x):  # type: ignore[no-untyped-def]
    """Mass and bias of motors and links: the arm moves as its links do, and transmissions pull on both."""
    mass, bias, w, arm = s.square[MASS], s.w[BIAS], s.w, s.arm
    count = arm.shape[1]
    for j in range(count):
        link = int(w[LINK, j])
        arm[count, j], arm[count + 1, j] = x[Q, link], x[V, link]
    s.rigid(arm[count], arm[count + 1], s.p, arm[:count], arm[count + 2])
    mass[:] = 0.0
    bias[:] = 0.0
    for j in range(count):
        link = int(w[LINK, j])
        bias[link] += arm[count + 2, j]
        for i in range(count):
            mass[link, int(w[LINK, i])] += arm[j, i]
        if link != j:
            force = transmitted(w, j, x[Q, j] - x[Q, link], x[V, j] - x[V, link])
            bias[j] += force
            bias[link] -= force
            mass[j, j] += w[ROTOR, j]
            mass[link, link] -= w[ROTOR, j]


@jit
def transmitted(w, joint, ahead, rate):  # type: ignore[no-untyped-def]
    """Force of a motor that is `ahead` of its link, gaining on it at `rate`. In a gap none; a contact does not pull."""
    half = w[GAP, joint] / 2
    if half == 0.0:
        return w[STIFFNESS, joint] * ahead + w[DAMPING, joint] * rate
    way = 1.0 if ahead > 0 else -1.0
    deep = way * ahead - half
    if deep <= 0.0:
        return 0.0
    damping = w[DAMPING, joint] * min(1.0, deep / (_ENGAGED * w[GAP, joint]))
    return way * max(0.0, w[STIFFNESS, joint] * deep + damping * way * rate)


@jit
def _effects(s, t, x):  # type: ignore[no-untyped-def]
    """Torques and levels of all effects at the acceleration of x; what is linear in it is in the mass."""
    w, mass, n = s.w, s.square[MASS], len(s.mode)
    for j in range(n):
        w[EFFECT, j] = w[LEVEL, j] = w[LOAD, j] = 0.0
    for needs in range(0, LOADED + 1, LOADED):
        if needs and not s.loaded:
            break
        for j in range(n if needs else 0):
            slips = s.mode[j] if s.mode[j] != FREE else 0
            dry = slips * w[LEVEL, j]
            if (
                s.mode[j] == 0
            ):  # as much as holds it: a level that jumped at break-away would stick and slip without end
                dry = min(max(w[HELD, j], -w[LEVEL, j]), w[LEVEL, j])
            w[TAU, j] = w[BIAS, j] + w[EFFECT, j] + dry
            for i in range(n):
                w[TAU, j] += mass[j, i] * x[A, i]
        for e in range(s.effects.shape[1]):
            flags = s.effects[2, e]
            if flags & LOADED == needs:
                w[LEVEL if flags & DRY else EFFECT, s.effects[1, e]] += _torque(s, e, t, x[Q])
    for j in range(n):
        if s.mode[j] == 0:
            w[LEVEL, j] = max(w[LEVEL, j], 0.0)


@jit
def _solve(s, x):  # type: ignore[no-untyped-def]
    """Accelerations of the joints in their modes; friction of those that stick."""
    w, mass, system, mode, n = s.w, s.square[MASS], s.square[INVERSE], s.mode, len(s.mode)
    for j in range(n):
        slips = mode[j] if mode[j] != FREE else 0
        load = w[DRIVE, j] - w[BIAS, j] - w[EFFECT, j] - slips * w[LEVEL, j]
        w[HELD, j] = load
        w[LOAD, j] = load if mode[j] != 0 else 0.0
        for i in range(n):
            both = mode[j] != 0 and mode[i] != 0
            system[j, i] = mass[j, i] if both else (1.0 if i == j else 0.0)
    if not _factorise(system, s.square[FACTOR]):
        return False
    _substitute(s.square[FACTOR], w[LOAD], x[A])
    for j in range(n):
        for i in range(n):
            w[HELD, j] -= mass[j, i] * x[A, i]
    return True


@jit
def _rest(s, x):  # type: ignore[no-untyped-def]
    """Friction of the joints at rest (projected Gauss-Seidel) and the acceleration of all."""
    w, inverse, mode, n = s.w, s.square[INVERSE], s.mode, len(s.mode)
    if not _factorise(s.square[MASS], s.square[FACTOR]):
        return False
    for i in range(n):
        for j in range(n):
            w[LOAD, j] = 1.0 if i == j else 0.0
        _substitute(s.square[FACTOR], w[LOAD], inverse[i])
    for j in range(n):
        slips = mode[j] if mode[j] != FREE else 0
        w[LOAD, j] = w[DRIVE, j] - w[BIAS, j] - w[EFFECT, j] - slips * w[LEVEL, j]
        w[HELD, j] = min(max(w[HELD, j], -w[LEVEL, j]), w[LEVEL, j]) if mode[j] == 0 else 0.0
    for _ in range(1000):
        moved, size = 0.0, 0.0
        for j in range(n):
            x[A, j] = 0.0
            for i in range(n):
                x[A, j] += inverse[j, i] * (w[LOAD, i] - w[HELD, i])
            if mode[j] == 0:
                new = min(max(w[HELD, j] + x[A, j] / inverse[j, j], -w[LEVEL, j]), w[LEVEL, j])
                x[A, j] -= inverse[j, j] * (new - w[HELD, j])
                moved, size = max(moved, abs(new - w[HELD, j])), max(size, abs(new))
                w[HELD, j] = new
        if moved <= 1e-15 * size:
            break
    return True


@jit
def _accelerate(s, t, x, decide):  # type: ignore[no-untyped-def]
    """Acceleration of the state x, whose third row comes with a guess. Returns a status.

    `decide`: whether the joints at rest may change their modes.
    """
    w, mode = s.w, s.mode
    rests = False
    for j in range(len(mode)):
        if not (abs(x[Q, j]) < _FAR and abs(x[V, j]) < _FAR):
            return NOT_FINITE
        if decide and mode[j] != FREE:
            mode[j] = 0 if x[V, j] == 0 else (1 if x[V, j] > 0 else -1)
            rests = rests or mode[j] == 0
    _rigid(s, t, x)
    for iteration in range(_ITERATIONS):
        size, apart = 0.0, 0.0
        for j in range(len(mode)):
            w[BEFORE, j] = x[A, j]
        _effects(s, t, x)
        if not (_rest(s, x) if rests else _solve(s, x)):
            return NOT_POSITIVE
        for j in range(len(mode)):
            size, apart = max(size, abs(x[A, j])), max(apart, abs(x[A, j] - w[BEFORE, j]))
        if s.loaded and (iteration == 0 or apart > 1e-14 * (1 + size)):  # the friction that holds a joint is new, too
            continue
        if not rests:
            return OK
        for j in range(len(mode)):
            if mode[j] == 0 and abs(w[HELD, j]) >= w[LEVEL, j]:
                beyond = x[A, j] / s.square[INVERSE, j, j]
                mode[j] = 0 if abs(beyond) <= _margin(w, j) else (1 if beyond > 0 else -1)
        rests = False
        _rigid(s, t, x)
    return NO_FIXED_POINT


@jit
def _margin(w, j):  # type: ignore[no-untyped-def]
    return MARGIN * (w[LEVEL, j] + abs(w[DRIVE, j]) + abs(w[BIAS, j]) + abs(w[EFFECT, j]))


@jit
def _clear(s, x):  # type: ignore[no-untyped-def]
    """How far the joints are from the end of their modes: the least of all; negative beyond it."""
    least = np.inf
    for j in range(len(s.mode)):
        if s.mode[j] == 0:
            least = min(least, s.w[LEVEL, j] + 2 * _margin(s.w, j) - abs(s.w[HELD, j]))
        elif s.mode[j] != FREE:
            least = min(least, s.mode[j] * x[V, j])
    return least


@jit
def _step(s, t, h, x, y):  # type: ignore[no-untyped-def]
    """One Runge-Kutta step of order 4 from the state x to the state y, acceleration included. Returns a status."""
    z, n = s.w[STAGE : STAGE + 3], len(s.mode)  # a state
    sums = s.w[STAGE + 3 : STAGE + 5]
    for j in range(n):
        z[V, j], z[A, j], sums[0, j], sums[1, j] = x[V, j], x[A, j], x[V, j], x[A, j]
    status = OK
    for stage in range(1, 5):
        part = h if stage >= 3 else h / 2
        for j in range(n):
            speed = z[V, j]
            if stage < 4:
                z[Q, j], z[V, j] = x[Q, j] + part * speed, x[V, j] + part * z[A, j]
                weight = 1.0 if stage == 3 else 2.0
                sums[0, j] += weight * z[V, j]
            else:
                z[Q, j], z[V, j] = x[Q, j] + h / 6 * sums[0, j], x[V, j] + h / 6 * sums[1, j]
        status = max(status, _accelerate(s, t + part, z, False))
        for j in range(n):
            sums[1, j] += (1.0 if stage == 3 else 2.0) * z[A, j]
    for j in range(n):
        for row in range(3):
            y[row, j] = z[row, j]
    return status


@jit
def _dips(s, h, x, y):  # type: ignore[no-untyped-def]
    """Instant in (0, h) at which a joint is beyond rest although it is not at the end; 0 if there is none."""
    for j in range(len(s.mode)):
        sign = s.mode[j]
        if sign == 0 or sign == FREE:
            continue
        v0, v1, d0, d1 = sign * x[V, j], sign * y[V, j], sign * x[A, j] * h, sign * y[A, j] * h
        if v0 <= 0 or d0 >= 0 or d1 <= 0 or v1 < 0:
            continue
        # minimum of the cubic with these values and slopes
        c3, c2 = 2 * (v0 - v1) + d0 + d1, 3 * (v1 - v0) - 2 * d0 - d1
        under = c2 * c2 - 3 * c3 * d0
        if under <= 0:
            continue
        at = -d0 / (c2 + np.sqrt(under))
        if 0 < at < 1 and v0 + at * (d0 + at * (c2 + at * c3)) < 0:
            return at * h
    return 0.0


@jit
def _locate(s, t, h, x, y):  # type: ignore[no-untyped-def]
    """The step that ends just beyond the first end of a mode in (0, h]: its length and the state y where it leads.

    Regula falsi (Illinois); bisection while it is not known to start inside the mode.
    """
    low, high, at_low, at_high, side, middle = 0.0, h, 0.0, -1.0, 0, h
    for trial in range(200):
        last = high - low <= 1e-12 * h
        if last:
            middle = high
        elif at_low > 0:
            middle = (low * at_high - high * at_low) / (at_high - at_low)
            middle = min(max(middle, low + 1e-13 * h), high - 1e-13 * h)
        elif trial > 0:
            middle = (low + high) / 2
        _step(s, t, middle, x, y)
        if last:
            break
        value = _clear(s, y)
        if value < 0 or trial == 0:
            high, at_high = middle, value
            at_low = at_low / 2 if side == -1 else at_low
            side = -1
        else:
            low, at_low = middle, value
            at_high = at_high / 2 if side == 1 else at_high
            side = 1
    return high


@jit
def _remember(s, joint, q):  # type: ignore[no-untyped-def]
    """Where a joint came to rest, and how its bristles are bent there."""
    for e in range(s.effects.shape[1]):
        if s.effects[1, e] == joint and s.effects[2, e] & REMEMBERS:
            h = s.values[1, e]
            h[2] = bend(q, float(s.mode[joint]), h)
            h[1] = q


@jit
def _accept(s, t, h, clear, x, y):  # type: ignore[no-untyped-def]
    """Move the state x to y, the end of an accurate step of length h, or to the first end of a mode in it.

    `clear` is that of y. Returns the time moved, whether a mode ended, and the status.
    """
    until = h if clear < 0 else _dips(s, h, x, y)
    moved = h if until == 0.0 else _locate(s, t, until, x, y)
    for j in range(len(s.mode)):
        x[Q, j], x[V, j], x[A, j] = y[Q, j], y[V, j], y[A, j]
        if until > 0 and s.mode[j] != FREE and s.mode[j] * x[V, j] <= 0:
            x[V, j] = 0.0
            _remember(s, j, x[Q, j])
    return moved, until > 0, _accelerate(s, t + moved, x, True) if until > 0 else OK


@jit
def _disagreement(x, y, z, tolerance):  # type: ignore[no-untyped-def]
    """Error of two half steps from x to z, from their difference to the whole one to y, in units of the tolerance."""
    worst = 0.0
    for j in range(x.shape[1]):
        worst = max(worst, abs(z[Q, j] - y[Q, j]) / (15 * tolerance * (1 + abs(x[Q, j]))))
        worst = max(worst, abs(z[V, j] - y[V, j]) / (150 * tolerance * (1 + abs(x[V, j]))))
        if not (np.isfinite(z[Q, j]) and np.isfinite(z[V, j])):
            return np.inf
    return worst


@jit
def _advance(s, t, length, x, states, settings):  # type: ignore[no-untyped-def]
    """Move the state x over `length` s; settings: largest step, tolerance, next step, and 3 of scratch."""
    whole, middle, end = states[0], states[1], states[2]
    clear = settings[3:]
    events, tries, done = 0, 0, 0.0
    while length - done > 1e-12 * length:
        h = min(settings[2], length - done)
        tries += 1
        if tries > _TRIES:
            return STEP_TOO_SMALL
        status = OK
        for part in range(3):  # the whole step, then its halves
            late, begin = h / 2 if part == 2 else 0.0, middle if part == 2 else x
            status = max(status, _step(s, t + done + late, h if part == 0 else h / 2, begin, states[part]))
            clear[part] = _clear(s, states[part])
        if status != OK:
            return status
        worst = _disagreement(x, whole, end, settings[1])
        if worst == np.inf:
            return NOT_FINITE
        if worst > 1 and h <= 1e-9 * settings[0]:
            return STEP_TOO_SMALL
        if worst > 1:
            settings[2] = h / 2
            continue
        if worst < 1 / 64:
            settings[2] = min(max(2 * h, settings[2]), settings[0])
        for part in range(1, 3):
            moved, ended, status = _accept(s, t + done, h / 2, clear[part], x, states[part])
            done += moved
            events += ended
            if status != OK:
                return status
            if ended:
                break
        if events > _EVENTS:
            return TOO_MANY_EVENTS
    return OK


@jit
def _measure(q, count, phase, out):  # type: ignore[no-untyped-def]
    """Encoder: multiples of `count`, from a zero that lies anywhere within a count; count 0 is perfect."""
    for j in range(len(q)):
        out[j] = count[j] * (np.rint(q[j] / count[j] + phase[j]) - phase[j]) if count[j] > 0 else q[j]


_RUN = many(int64, 2)(
    types.FunctionType(PLANT),
    vector,
    many(types.FunctionType(FORWARD), SLOTS),
    table,
    cube,
    indices,
    matrix,
    matrix,
    cube,
    vector,
    vector,
    matrix,
    cube,
    vector,
    matrix,
    matrix,
    cube,
    cube,
)


@njit(_RUN, cache=True, error_model="numpy")
def run(  # type: ignore[no-untyped-def]
    rigid,
    p,
    forward,
    effects,
    values,
    mode,
    start,
    law,
    reference,
    clock,
    at,
    drive,
    out,
    settings,
    arm,
    w,
    square,
    states,
):
    """Simulate the closed loop.

    `rigid`, `p`: plant; `forward`, `effects`, `values`: as in System; `mode` (n,): FREE, or 0 for
    joints with dry friction; `start` (2, n): q and dq at t = 0; `law` (5, n): kp, kd, encoder count and phase, torque
    limit; `reference` (2, K, n): commanded positions and velocities at the control instants `clock` (K,) s; `at` (N,)
    s: instants to record; results: `drive` (K, n) torques, `out` (4, N, n) q, dq, ddq, modes; `settings`: largest step
    s, tolerance, next step s, 3 of scratch; `arm`, `w`, `square`, `states`: see `workspace`. Returns a status and the
    number of the control period where it ended.
    """
    n, p, effects, values, mode = len(mode), borrow(p), borrow(effects), borrow(values), borrow(mode)
    w, states, settings = borrow(w), borrow(states), borrow(settings)
    loaded = False
    for e in range(effects.shape[1]):
        loaded = loaded or effects[2, e] & LOADED != 0
        if effects[2, e] & REMEMBERS:
            values[1, e, 1], values[1, e, 2] = start[0, effects[1, e]], 0.0
    s = System(rigid, p, forward, effects, values, loaded, borrow(arm), mode, w, borrow(square))
    x = states[3]
    period = clock[1] - clock[0] if len(clock) > 1 else 1.0
    for j in range(n):
        x[Q, j], x[V, j] = start[0, j], start[1, j]
        w[SEEN, j] = x[Q, j] - period * x[V, j]
    _measure(w[SEEN], law[2], law[3], w[LAST])
    now = 0
    for k in range(len(clock)):
        t = clock[k]
        stop = clock[k + 1] if k + 1 < len(clock) else at[-1]
        _measure(x[Q], law[2], law[3], w[SEEN])
        for j in range(n):
            speed = (w[SEEN, j] - w[LAST, j]) / period
            w[DRIVE, j] = law[0, j] * (reference[0, k, j] - w[SEEN, j]) + law[1, j] * (reference[1, k, j] - speed)
            w[DRIVE, j] = min(max(w[DRIVE, j], -law[4, j]), law[4, j])
            drive[k, j] = w[DRIVE, j]
            w[LAST, j] = w[SEEN, j]
        status = _accelerate(s, t, x, True)
        while status == OK:
            due = now < len(at) and (at[now] < stop - 1e-9 * period or k + 1 == len(clock))
            to = at[now] if due else stop
            if to > t + 1e-9 * period:
                status = _advance(s, t, to - t, x, states, settings)
                t = to
            if not due or status != OK:
                break
            for j in range(n):
                out[3, now, j] = mode[j]
                for row in range(3):
                    out[row, now, j] = x[row, j]
            now += 1
        if status != OK:
            return status, k
    return OK, len(clock)


def workspace(link: np.ndarray, hung: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Arrays for `run`: `link` (J,) numbers of the links, `hung` (4, J) how they hang; rows LINK to ROTOR."""
    joints, count = len(link), max(len(link), int(link.max()) + 1)
    w = np.zeros((ROWS, count))
    w[LINK, :joints], w[STIFFNESS:, :joints] = link, hung
    return np.zeros((joints + 3, joints)), w, np.zeros((3, count, count)), np.zeros((4, 3, count))
