"""Spikes: samples, up to four in a row, that leave a smooth curve and come back to it.

A suspect is left out and a cubic fitted to eight samples on either side, on their own stamps. It is a spike when it
lies `limit` deviations off that cubic, the deviation being the local noise or the misfit of the neighbours themselves,
whichever is larger. The misfit is what spares real motion: at a step, at a kink, or where the acceleration switches, no
sample lies more than about three misfits off, whatever the rate. Only what leaves and comes back goes beyond.
"""

import numpy as np
from numpy.typing import NDArray

from chebid.log.roughness import Array, Scale, local_noise, roughness, scale_of

_SIDE = 8  # neighbours on either side
_TERMS = 4  # of the cubic
_SUSPECT = (0.75, 0.7, 1.1, 1.8)  # of the limit, from which roughness makes a sample a suspect, or the one before it
_END = 4.0  # near an end the cubic extrapolates: so much more is asked for
_LONGER = (1.0, 1.5, 2.5, 4.0)  # a real motion can look like a run of several samples: so much more again
_QUANTA = 0.35  # least noise in quanta: counting gives 0.29, and steps
_BATCH = 50_000


def find_spikes(t: Array, x: Array, limit: float, least: float = 0.0, scale: Scale | None = None) -> NDArray[np.bool_]:
    """Which samples of `x` (N,) at stamps `t` (N,) are spikes: off by `limit` deviations, and by `least` at least.

    `scale` is that of the whole column when `x` is a part of it.
    """
    scale = scale or scale_of(t, x)
    spikes = np.zeros(len(x), dtype=bool)
    for _ in range(3):  # a spike hides its neighbours until it is taken out
        rest = np.flatnonzero(~spikes)
        found = _one_pass(t[rest], x[rest], limit, least, scale.at(rest))
        spikes[rest[found]] = True
        if not found.any() or spikes.mean() > 0.1:
            break
    return spikes


def _one_pass(t: Array, x: Array, limit: float, least: float, scale: Scale) -> NDArray[np.bool_]:
    found = np.zeros(len(x), dtype=bool)
    if len(x) < 2 * _SIDE + len(_LONGER):
        return found
    r = roughness(t, x)
    noise = np.maximum(local_noise(r), 0.5 * scale.noise)
    floor = np.maximum(noise, _QUANTA * scale.fine)
    rough = np.where(r > scale.fine, r / np.maximum(limit * noise, 1e-300), 0.0)
    for length in range(1, len(_LONGER) + 1):
        places = np.flatnonzero(rough > _SUSPECT[length - 1])
        if length > 1:
            places = np.union1d(places, places + 1)  # the roughest sample may be the one before a run
        places = places[(places > 0) & (places + length < len(x))]  # at the very ends: left to the jumps
        for batch in np.array_split(places, len(places) // _BATCH + 1):
            for start in batch[_stands_out(t, x, floor, batch, length, limit, least)]:
                if not found[max(start - 1, 0) : start + length + 1].any():
                    found[start : start + length] = True
    return found


def _stands_out(
    t: Array, x: Array, floor: Array, places: NDArray[np.intp], length: int, limit: float, least: float
) -> NDArray[np.bool_]:
    """Which of the runs of `length` samples that begin at `places` are spikes from their first to their last sample."""
    off, misfit = distance(t, x, places, length)
    scale = np.maximum(misfit, floor[places])
    end = (places < 3) | (places + length > len(x) - 3)
    factor = np.where(end, _END if length == 1 else np.inf, _LONGER[length - 1])
    return np.asarray((off > np.maximum(limit * factor * scale, least)[:, None]).all(axis=1))


def distance(t: Array, x: Array, places: NDArray[np.intp], length: int) -> tuple[Array, Array]:
    """How far the runs lie off the cubic through their neighbours, (P, length), and the misfit of these, (P,).

    Distances are divided by sqrt(1 + leverage), so that for white noise both have its deviation.
    """
    first = np.clip(places - _SIDE, 0, len(x) - 2 * _SIDE - length)
    window = first[:, None] + np.arange(2 * _SIDE + length)
    beside = (window < places[:, None]) | (window >= places[:, None] + length)
    near = window[beside].reshape(len(places), 2 * _SIDE)
    run = places[:, None] + np.arange(length)
    centre = t[near].mean(axis=1, keepdims=True)
    half = np.ptp(t[near], axis=1)[:, None] / 2
    level = x[near].mean(axis=1, keepdims=True)
    powers = np.arange(_TERMS)
    design = ((t[near] - centre) / half)[:, :, None] ** powers
    values = x[near] - level
    gram = np.einsum("pij,pik->pjk", design, design)  # singular for stamps as uneven as those of a broken clock
    inverse = np.linalg.inv(gram + 1e-9 * np.eye(_TERMS))
    weights = np.einsum("pjk,pik,pi->pj", inverse, design, values)
    misfit = np.sqrt(((values - np.einsum("pij,pj->pi", design, weights)) ** 2).sum(axis=1) / (2 * _SIDE - _TERMS))
    at = ((t[run] - centre) / half)[:, :, None] ** powers
    leverage = np.einsum("pij,pjk,pik->pi", at, inverse, at)
    off = np.abs(x[run] - level - np.einsum("pij,pj->pi", at, weights))
    return off / np.sqrt(1.0 + leverage), misfit
