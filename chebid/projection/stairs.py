"""Stairs: what a coarse encoder makes of a slow motion. Its error is white only above a count per sample."""

import numpy as np

from chebid.basis import Array

STAIRS = 3.0  # samples from change to change: more are stairs, and only changes are independent
_BLOCKS, _FEWEST = 64, 50  # parts of a record in which changes are counted, and samples in each


def samples_per_change(x: Array) -> float:
    """Samples from one change of the value x (N,) to the next, in those parts of a record where most changes are."""
    changed = x[1:] != x[:-1]
    blocks = np.array_split(changed, int(np.clip(len(changed) / _FEWEST, 1, _BLOCKS)))
    counts = np.array([np.count_nonzero(block) for block in blocks])
    if counts.sum() == 0:
        return 1.0
    return float(counts.sum() / np.sum(counts**2 / [max(len(block), 1) for block in blocks]))
