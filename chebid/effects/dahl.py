"""Dahl's bristle along a motion: dz/dq = (1 - z sign dq)/delta, solved exactly from sample to sample.

Between two samples q goes one way by a distance x, and the bend z (relative to the fully bent bristle) approaches
that direction s: z = s - (s - z0) exp(-x/delta). Within a run of one direction the distances add up, so only the
reversals are taken one after the other. Source: Dahl, A solid friction model, TOR-158 (1968), with exponent 1.
"""

import numpy as np

from chebid.robots import Array


def bristle(q: Array, delta: float, z0: float = 0.0) -> Array:
    """Bend z (N,) in [-1, 1] along positions q (N,), `delta` in the unit of q, from z0 at the first sample."""
    step = np.diff(q)
    way = np.sign(step)
    first = np.flatnonzero(np.diff(way, prepend=np.nan) != 0)  # of each run of one direction
    if first.size == 0:
        return np.full(len(q), z0)
    gone = np.cumsum(np.abs(step)) / delta
    before = np.concatenate([[0.0], gone])[first]
    lengths = np.diff(np.append(first, len(step)))
    at_end = np.exp(-(gone[first + lengths - 1] - before))
    begin = _each_run(way[first], at_end, z0)
    left = np.exp(-(gone - np.repeat(before, lengths)))
    z = way - (way - np.repeat(begin, lengths)) * left
    return np.concatenate([[z0], np.where(way == 0, np.repeat(begin, lengths), z)])


def _each_run(way: Array, decay: Array, z: float) -> Array:
    """Bend at the beginning of each run."""
    out = np.empty(len(way))
    for i, (s, e) in enumerate(zip(way.tolist(), decay.tolist(), strict=True)):
        out[i] = z
        if s:
            z = s - (s - z) * e
    return out
