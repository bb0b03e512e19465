"""Which columns of a regressor are nothing but a combination of those before them, whatever the motion."""

import numpy as np

from chebid.robots import Array

_SAME = 1e-9  # of a column's length: what is left of it that is rounding
_PART = 1e-6  # of the largest: a column that takes no part in the combination


def dependent_columns(columns: Array, first: int) -> dict[int, list[int]]:
    """For columns (R, P) from index `first` on: those that depend, each with the columns that it is made of.

    A column of zeros does not count: it depends on the motion that was tried.
    """
    size = np.linalg.norm(columns, axis=0)
    kept = [i for i in range(first) if size[i] > 0]
    out: dict[int, list[int]] = {}
    basis = np.linalg.qr(columns[:, kept] / size[kept])[0] if kept else np.zeros((len(columns), 0))
    for i in range(first, columns.shape[1]):
        if not size[i] > 0:
            continue
        left = columns[:, i] / size[i]
        for _ in range(2):  # once more for what rounding left
            left = left - basis @ (basis.T @ left)
        length = float(np.linalg.norm(left))
        if length < _SAME:
            out[i] = _made_of(columns, i, kept)
        else:
            basis = np.column_stack([basis, left / length])
            kept.append(i)
    return out


def _made_of(columns: Array, i: int, kept: list[int]) -> list[int]:
    size = np.linalg.norm(columns[:, kept], axis=0)
    share = np.abs(np.linalg.lstsq(columns[:, kept] / size, columns[:, i])[0])
    return [k for k, part in zip(kept, share, strict=True) if part > _PART * share.max()]
