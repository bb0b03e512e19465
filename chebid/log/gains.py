"""Logged units to SI units: q = G . logged + offset, with G a number, one per joint, or a matrix."""

import numpy as np
from numpy.typing import NDArray

from chebid.errors import InputError, Place
from chebid.log.record import Gain


def gain_matrix(gain: Gain, joints: int, columns: int, key: str) -> NDArray[np.float64]:
    """The gain as a matrix (joints, columns). Raises InputError when its shape does not fit."""
    value = np.asarray(gain, dtype=np.float64)
    if value.ndim == 2 and value.shape == (joints, columns):
        return value
    if value.ndim < 2 and joints == columns and value.size in (1, joints):
        return np.diag(np.broadcast_to(value.reshape(-1), (joints,)).astype(np.float64))
    if value.ndim < 2 and joints != columns:
        role = key.removesuffix("_gain")
        raise InputError(
            f"names {columns} columns for {joints} joints",
            hint=f"name one column per joint, or give '{key}' as a matrix with a row per joint",
            place=Place(key=f"log: {role}"),
        )
    raise InputError(
        f"does not fit {columns} columns for {joints} joints",
        hint="give one number, one per joint, or a matrix with a row per joint and an entry per column",
        place=Place(key=f"log: {key}", value=gain),
    )


def apply_gain(logged: NDArray[np.float64], gain: NDArray[np.float64], offset: object = 0.0) -> NDArray[np.float64]:
    """`logged` (N, columns) to (N, joints); a missing sample spoils only the joints that its column enters."""
    if gain.shape[0] == gain.shape[1] and not (gain - np.diag(np.diagonal(gain))).any():
        return logged * np.diagonal(gain) + np.asarray(offset, dtype=np.float64)
    missing = np.isnan(logged)
    values = np.where(missing, 0.0, logged) @ gain.T + np.asarray(offset, dtype=np.float64)
    spoiled = missing.astype(np.float64) @ (gain != 0).T.astype(np.float64) > 0
    values[spoiled] = np.nan
    return values
