"""Test functions: what both sides of an equation are multiplied by and summed over, one row each.

A record is divided into equal stretches of time. On a stretch the functions of the band are the polynomials of degree
n = 2 f T, orthonormal on its samples. Of these, each joint takes the combinations that live where it moves: the
eigenvectors of their Gram matrix over the moving samples (as Slepian's sequences, Bell Syst. Tech. J. 57, 1978).
Two ways to leave out the slow samples:

- As long as q is passed whole, errors stand only at slow speed. The equations are set to zero there before they are
  projected, and the functions made orthonormal on what is left.
- When the degree is too low for q, what is missing from its accelerations lies above the band and would be spread
  into it by that cut. Then the whole equation is projected first, which takes it away from both sides, and only
  functions that lie almost wholly in the motion are used.

Either way white noise on the torque is white on the rows, and there are as many as there are independent equations,
so that eq. 26 is honest.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from chebid.basis import Array
from chebid.motion import Mask, Track
from chebid.projection.modes import degree_modes

_SHARP = 2.5  # n <= 2.5 sqrt(N) on a stretch: its polynomials stay well conditioned
_LONGEST = 150  # degree on a stretch: more would only cost time
_HALF = 0.5  # of a function's energy in the motion, where the equation is cut to the motion
_MOST = 0.9  # of it, where the equation is not cut


@dataclass(frozen=True)
class Functions:
    """Test functions of one stretch: `number` from 0, `piece` its samples, joint by joint `basis` @ `mix`[j].T.

    `basis` (N_s, n + 1), `mix` (k_j, n + 1) by rising frequency, `mask` (N_s, J) the samples that are projected.
    """

    number: int
    piece: slice
    basis: Array
    mask: Mask
    mix: tuple[Array, ...]

    def rows(self, columns: Array) -> list[Array]:
        """For every joint the rows (k_j, K) of its columns (N_s, J, K) at the samples of the stretch."""
        samples, joints, width = columns.shape
        known = np.where(self.mask[:, :, None], columns, 0.0).reshape(samples, -1)
        products = (self.basis.T @ known).reshape(-1, joints, width)
        return [mix @ products[:, j] for j, mix in enumerate(self.mix)]


def moving_functions(track: Track, used: Mask, valid: Mask, band: float) -> Iterator[Functions]:
    """Functions up to `band` Hz of every stretch in which a joint moves: `used` (N, J), of the `valid` (N,) samples."""
    whole = track.whole
    mask = used if whole else np.repeat(valid[:, None], used.shape[1], axis=1)
    for number, (piece, basis) in enumerate(stretch_bases(track, band, len(used))):
        if used[piece].any():
            mix = tuple(_living_in(basis, moving, whole) for moving in used[piece].T)
            yield Functions(number, piece, basis, mask[piece], mix)


def _living_in(basis: Array, moving: Mask, cut: bool) -> Array:
    """Combinations (k, n + 1) of the basis that live in the motion; orthonormal there if equations are `cut` to it."""
    count = basis.shape[1]
    if moving.all():
        return np.eye(count)
    share, vectors = np.linalg.eigh(np.eye(count) - basis[~moving].T @ basis[~moving])
    kept = share > (_HALF if cut else _MOST)
    share, vectors = share[kept], vectors[:, kept]
    # within these, by frequency: the noise of a torque depends on it
    turn = np.linalg.eigh(vectors.T @ (np.arange(count)[:, None] ** 2 * vectors))[1]
    return turn.T @ (vectors / np.sqrt(share) if cut else vectors).T


def stretch_bases(track: Track, band: float, count: int) -> Iterator[tuple[slice, Array]]:
    """Equal stretches of the first `count` samples, each with polynomials orthonormal on them (N_s, n + 1)."""
    longest = min(_LONGEST / (2 * band), track.rate * (_SHARP / (2 * band)) ** 2)  # n = 2 f T <= 2.5 sqrt(N)
    size = int(np.clip(longest * track.rate, 16, count))
    edges = np.linspace(0, count, -(-count // size) + 1).astype(int)
    cache: dict[int, Array] = {}
    for start, stop in itertools.pairwise(edges):
        piece = slice(int(start), int(stop))
        yield piece, _basis(track, piece, _degree(stop - start, band, track.rate), cache)


def _degree(samples: int, band: float, rate: float) -> int:
    """n = 2 f T, as many polynomials as the band holds independent values; never less than a cubic."""
    return int(np.clip(np.ceil(2 * band * samples / rate), 3, min(samples - 1, int(_SHARP * np.sqrt(samples)))))


def _basis(track: Track, piece: slice, degree: int, cache: dict[int, Array]) -> Array:
    """Orthonormal polynomials (N, n + 1) on the samples of a stretch."""
    t = track.motion.t[piece]
    if not track.projections[0].operator.uniform:
        return degree_modes(2 * (t - t[0]) / (t[-1] - t[0]) - 1, degree).samples
    if len(t) not in cache:
        cache[len(t)] = degree_modes(np.linspace(-1.0, 1.0, len(t)), degree).samples
    return cache[len(t)]
