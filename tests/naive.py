"""Slow, obvious twins of the fast code: everything at once, sample by sample, nothing shared with it."""

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
