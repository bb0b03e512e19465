"""Slow, obvious twins of the fast code: everything at once, sample by sample, nothing shared with it."""

from fractions import Fraction

import numpy as np

from chebid.effects import Motion


def system(track, dynamics):
    """[W Y] (N, J, P + 1), one sample at a time."""
    m = track.motion
    out = []
    for i in range(len(m.t)):
        one = dynamics.regressor(Motion(m.t[[i]], m.q[[i]], m.dq[[i]], m.ddq[[i]]))[0]
        out.append(np.column_stack([one, track.tau[i]]))
    return np.array(out)


def stretches(count, rate, band):
    """Ends of the stretches: as few equal ones as keep the degree n = 2 f T at 150 and at 2.5 sqrt(N) at most."""
    longest = min(150 / (2 * band) * rate, rate**2 * (2.5 / (2 * band)) ** 2)
    pieces = int(np.ceil(count / int(np.clip(longest, 16, count))))
    return [(int(count * k / pieces), int(count * (k + 1) / pieces)) for k in range(pieces)]


def projected_rows(track, dynamics, gate, band):
    """One [W Y] (R, P + 1) a joint, up to a rotation of the rows of each stretch.

    Legendre polynomials, and the functions that live in the motion from a singular value decomposition.
    """
    whole = system(track, dynamics)
    count, joints = whole.shape[:2]
    out = [[] for _ in range(joints)]
    for first, last in stretches(count, track.rate, band):
        n = int(np.clip(np.ceil(2 * band * (last - first) / track.rate), 3, 2.5 * np.sqrt(last - first)))
        t = track.motion.t[first:last]
        basis = np.linalg.qr(np.polynomial.legendre.legvander(2 * (t - t[0]) / (t[-1] - t[0]) - 1, n))[0]
        for j in range(joints):
            fast = track.valid[first:last] & (np.abs(track.motion.dq[first:last, j]) >= gate[j])
            u, s, v = np.linalg.svd(basis[fast], full_matrices=False)
            if track.whole:
                functions = np.zeros((last - first, int(np.sum(s**2 > 0.5))))
                functions[fast] = u[:, s**2 > 0.5]
            else:
                functions = np.where(track.valid[first:last, None], basis @ v[s**2 > 0.9].T, 0.0)
            known = np.nan_to_num(whole[first:last, j])
            out[j].append(functions.T @ known)
    return [np.concatenate(part) for part in out]


# --- bases and projections


def polynomials(family, tau, n):
    """P_0 .. P_n (N, n + 1) by their closed forms in theta = arccos tau, or by numpy."""
    theta, k = np.arccos(tau)[:, None], np.arange(n + 1)
    if family == "chebyshev":
        return np.cos(k * theta)
    if family == "chebyshev2":
        ends = np.where(tau > 0, 1, (-1.0) ** k[:, None]).T * (k + 1)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.where(np.abs(tau[:, None]) == 1, ends, np.sin((k + 1) * theta) / np.sin(theta))
    return np.polynomial.legendre.legvander(tau, n)


def derivative_matrix(n):
    """D of eq. 27 and 28, row by row: P_k' = 2 k (P_{k-1} + P_{k-3} + ...), and half as much of P_0."""
    d = np.zeros((n + 1, n + 1))
    for k in range(n + 1):
        for j in range(k - 1, -1, -2):
            d[k, j] = 2 * k if j else k
    return d


def pseudo_inverse(family, tau, x, n):
    """Eq. 11 (with the measured samples): coefficients (n + 1, ...) by the pseudo-inverse of the dense P."""
    return np.linalg.pinv(polynomials(family, tau, n), rcond=1e-15) @ x


def annex_i(i, low, high):
    """I_i: integral of T_i / sqrt(1 - tau^2) from low to high (annex 5.1)."""
    a, b = np.arccos(high), np.arccos(low)
    return b - a if i == 0 else (np.sin(i * b) - np.sin(i * a)) / i


def annex_j(i, low, high):
    """J_i: the same with tau T_i; for i >= 2 with the i that the printed annex lacks inside the second sine."""
    if i == 0:
        return np.sqrt(1 - low**2) - np.sqrt(1 - high**2)
    if i == 1:
        a, b = np.arccos(high), np.arccos(low)
        return (b - a) / 2 + (np.sin(2 * b) - np.sin(2 * a)) / 4

    def primitive(tau):
        a = np.arccos(tau)
        return (np.sin(a) * np.cos(i * a) - i * tau * np.sin(i * a)) / (i**2 - 1)

    return primitive(high) - primitive(low)


def annex(tau, x, n):
    """Eq. 9 by the annex: segment by segment and degree by degree, x = slope tau + level on each segment."""
    out = np.zeros(n + 1)
    for k in range(len(tau) - 1):
        slope = (x[k + 1] - x[k]) / (tau[k + 1] - tau[k])
        level = x[k] - slope * tau[k]
        for i in range(n + 1):
            out[i] += level * annex_i(i, tau[k], tau[k + 1]) + slope * annex_j(i, tau[k], tau[k + 1])
    return out / np.where(np.arange(n + 1) == 0, np.pi, np.pi / 2)


def annex_dense(tau, x, n):
    """The same with matrices (N - 1, n + 1), as the annex is printed; for x (N,)."""
    i = np.arange(n + 1)
    a = np.arccos(tau)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.where(i == 0, -a, -np.sin(i * a) / i)
        second = (np.sin(a) * np.cos(i * a) - i * np.cos(a) * np.sin(i * a)) / (i**2.0 - 1)
    second[:, 0] = -np.sin(a[:, 0])
    if n:
        second[:, 1] = -(a[:, 0] / 2 + np.sin(2 * a[:, 0]) / 4)
    slope = np.diff(x) / np.diff(tau)
    level = x[:-1] - slope * tau[:-1]
    return (level @ np.diff(first, axis=0) + slope @ np.diff(second, axis=0)) / np.where(i == 0, np.pi, np.pi / 2)


def penalised(tau, x, n, order, weight):
    """Legendre coefficients of the least of sum r^2 + weight int (x^(m))^2: normal equations, in fractions."""
    p = [[Fraction(1), Fraction(float(at))] for at in tau]
    for row in p:
        for i in range(1, n):
            row.append(((2 * i + 1) * row[1] * row[i] - i * row[i - 1]) / (i + 1))
    derivatives = [
        [Fraction(int(i == j)) for j in range(n + 1)] for i in range(n + 1)
    ]  # row i: coefficients of P_i^(m)
    for _ in range(order):
        derivatives = [
            [sum(c[k] for k in range(j + 1, n + 1, 2)) * (2 * j + 1) for j in range(n + 1)] for c in derivatives
        ]
    normal = [[_dot([r[i] for r in p], [r[j] for r in p]) for j in range(n + 1)] for i in range(n + 1)]
    for i in range(n + 1):
        for j in range(n + 1):
            terms = (
                a * b * 2 / (2 * k + 1) for k, (a, b) in enumerate(zip(derivatives[i], derivatives[j], strict=True))
            )
            normal[i][j] += Fraction(float(weight)) * sum(terms)
    return _solve(normal, [_dot([r[i] for r in p], [Fraction(float(v)) for v in x]) for i in range(n + 1)])


def _dot(a, b):
    return sum(u * v for u, v in zip(a, b, strict=True))


def _solve(matrix, right):
    """Gauss and Jordan, exactly."""
    rows = [[*row, r] for row, r in zip(matrix, right, strict=True)]
    for i in range(len(rows)):
        pivot = next(k for k in range(i, len(rows)) if rows[k][i] != 0)
        rows[i], rows[pivot] = rows[pivot], rows[i]
        rows[i] = [v / rows[i][i] for v in rows[i]]
        for k in range(len(rows)):
            if k != i:
                rows[k] = [v - rows[k][i] * u for v, u in zip(rows[k], rows[i], strict=True)]
    return np.array([float(row[-1]) for row in rows])


def wiener(t, x, half, slope, band, order=0):
    """The best estimate of a random motion in white noise (N,), by covariance matrices (N, N) and no polynomial.

    The acceleration has the spectrum 1 / (1 + (f / band)^(2 slope)); the motion is as strong as the noise at `half` Hz;
    any straight line may be added to it.
    """
    t = t - t[0]
    rate, step = (len(t) - 1) / t[-1], half / 400
    covariance, cross = np.zeros((len(t), len(t))), np.zeros((len(t), len(t)))
    for f in np.arange(step / 2, 6 * half, step):
        w = 2 * np.pi * f
        shape = (1 + (half / band) ** (2 * slope)) / (1 + (f / band) ** (2 * slope))
        variance = 2 * step * shape * (2 * np.pi * half) ** 4 / rate  # of cos and of sin, in squares of the noise
        bent = np.column_stack([np.cos(w * t), np.sin(w * t)])
        moved = np.column_stack([(1 - np.cos(w * t)) / w**2, (t - np.sin(w * t) / w) / w])
        covariance += variance * moved @ moved.T
        cross += variance * (moved if order == 0 else bent) @ moved.T
    line = np.column_stack([np.ones_like(t), t])
    inverse = np.linalg.inv(covariance + np.eye(len(t)))
    c = np.linalg.solve(line.T @ inverse @ line, line.T @ inverse @ x)
    return cross @ inverse @ (x - line @ c) + (line @ c if order == 0 else 0)


def restricted_likelihood(x, covariance, free):
    """-2 log L / (N - m) of x (N,) with covariance sigma^2 (I + `covariance`) and any combination of `free` (N, m)."""
    total = np.eye(len(x)) + covariance
    inverse = np.linalg.inv(total)
    gram = free.T @ inverse @ free
    rest = inverse - inverse @ free @ np.linalg.solve(gram, free.T @ inverse)
    count = len(x) - free.shape[1]
    logs = np.linalg.slogdet(total)[1] + np.linalg.slogdet(gram)[1] - np.linalg.slogdet(free.T @ free)[1]
    return np.log(x @ rest @ x / count) + logs / count


def smoothstep(u):
    """0 below 0, 1 above 1, three continuous derivatives."""
    u = min(max(u, 0.0), 1.0)
    return 35 * u**4 - 84 * u**5 + 70 * u**6 - 20 * u**7


def blended(t, windows, values):
    """Values at t (N,) of functions on `windows` (start, stop), blended over the middle 40 % of each overlap."""
    out = np.zeros(len(t))
    for n, at in enumerate(t):
        for k, (start, stop) in enumerate(windows):
            if not start - 1e-9 <= at <= stop + 1e-9:
                continue
            weight = 1.0
            if k > 0:
                overlap = windows[k - 1][1] - start
                weight *= smoothstep((at - start - 0.3 * overlap) / (0.4 * overlap))
            if k < len(windows) - 1:
                overlap = stop - windows[k + 1][0]
                weight *= 1 - smoothstep((at - windows[k + 1][0] - 0.3 * overlap) / (0.4 * overlap))
            if weight > 0:
                out[n] += weight * values[k](at)
    return out
