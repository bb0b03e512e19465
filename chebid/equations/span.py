"""What columns span: the basis by which effects are told from models, in the critique and in the search of motions."""

import numpy as np

from chebid.basis import Array

_RANK = 1e-9  # of the largest singular value, columns scaled to length 1: below it a direction is rounding


def orthonormal(columns: Array) -> Array:
    """An orthonormal basis (R, m) of what columns (R, P) span."""
    length = np.linalg.norm(columns, axis=0)
    columns = columns[:, length > 0] / length[length > 0]
    if not columns.shape[1]:
        return columns
    u, singular, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, singular > _RANK * singular[0]])
