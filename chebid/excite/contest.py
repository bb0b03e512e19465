"""How well each rival could pass for another on a motion.

Suppose that a rival with certain settings and values, a *truth*, is what the model lacks. Another rival is fitted in
its place, its own settings free, the model's parameters free as well. What it cannot imitate is

    E = min over its settings of || a - [W B] x ||^2,  minimised over x,

with a the torque of the truth, W the model's columns, B those of the other rival, each row divided by the torque noise.
E is the drop in the squared residual by which the truth would do better; E/2 the difference of their scores (log
likelihoods). Motions are judged by the smallest E of all ordered pairs, which is what a careless choice would get.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chebid.dynamics import Dynamics
from chebid.effects import Effect, Motion
from chebid.equations.span import orthonormal
from chebid.robots import Array

_SAME = 1e-12  # of a column's squared length: what is left of it beside the model's is rounding


@dataclass(frozen=True)
class Truth:
    """A rival (by its number) as it may be: settings, values (k,) of its parameters; `sized`: a log tells them."""

    rival: int
    effect: Effect
    values: Array
    sized: bool = False


@dataclass(frozen=True)
class Piece:
    """A motion, what each of its rows counts (N, J), of which every `step`-th is used."""

    motion: Motion
    weight: Array
    step: int = 1

    def whiten(self, columns: Array) -> Array:
        """Rows (R, K) of columns (N, J, K)."""
        used = columns[:: self.step] * self.weight[:: self.step, :, None]
        return used.reshape(-1, columns.shape[2])


@dataclass(frozen=True)
class Duel:
    """A truth against another rival: the numbers of truth and rival."""

    truth: int
    rival: int


@dataclass(frozen=True)
class Outcome:
    """Of a duel, by settings of the imitator: `left` (S,) is E; `most`: E without the imitator."""

    duel: Duel
    left: Array
    most: float
    values: Array  # (S, k) of the imitator

    @property
    def best(self) -> int:
        """The setting that imitates best."""
        return int(np.argmin(self.left))


@dataclass(frozen=True)
class Contest:
    """Truths, and for each rival the settings with which it may imitate. `duels`: which are fought."""

    dynamics: Dynamics
    truths: tuple[Truth, ...]
    settings: tuple[tuple[Effect, ...], ...]
    duels: tuple[Duel, ...]

    def with_settings(self, more: Sequence[tuple[int, Effect]]) -> "Contest":
        """With further settings: number of the rival, effect."""
        added = [tuple(e for r, e in more if r == number and e not in own) for number, own in enumerate(self.settings)]
        return replace(self, settings=tuple((*own, *new) for own, new in zip(self.settings, added, strict=True)))

    def outcomes(self, pieces: Sequence[Piece]) -> list[Outcome]:
        """Every duel on motions taken together."""
        basis = orthonormal(self.model_rows(pieces))
        fought = {duel.truth for duel in self.duels}
        truths = {i: beside(basis, self.truth_rows(i, pieces)) for i in fought}
        blocks = {r: self._blocks(r, basis, pieces) for r in {duel.rival for duel in self.duels}}
        signed = [own[0].one_way if own else False for own in self.settings]
        return [_outcome(d, truths[d.truth], blocks[d.rival], signed[d.rival]) for d in self.duels]

    def imitated(self, duel: Duel, pieces: Sequence[Piece]) -> Callable[[Effect], float]:
        """E of a duel on these motions as a function of the imitator."""
        basis = orthonormal(self.model_rows(pieces))
        truth = beside(basis, self.truth_rows(duel.truth, pieces))

        def left(effect: Effect) -> float:
            rows = self.effect_rows(effect, pieces)
            block = beside(basis, rows)[None], np.linalg.norm(rows, axis=0)[None]
            return float(_outcome(duel, truth, block, effect.one_way).left[0])

        return left

    def model_rows(self, pieces: Sequence[Piece]) -> Array:
        """W (R, P)."""
        return np.concatenate([piece.whiten(self.dynamics.regressor(piece.motion)) for piece in pieces])

    def truth_rows(self, number: int, pieces: Sequence[Piece]) -> Array:
        """The torque (R,) of a truth."""
        truth = self.truths[number]
        return self.effect_rows(truth.effect, pieces) @ truth.values

    def effect_rows(self, effect: Effect, pieces: Sequence[Piece]) -> Array:
        """(R, k)."""
        return np.concatenate([piece.whiten(self.dynamics.block(effect, piece.motion)) for piece in pieces])

    def _blocks(self, rival: int, basis: Array, pieces: Sequence[Piece]) -> tuple[Array, Array]:
        """Columns (S, R, k) of every setting beside the model's, those missing zero, and their lengths (S, k)."""
        rows = [self.effect_rows(effect, pieces) for effect in self.settings[rival]]
        width = max(part.shape[1] for part in rows)
        wide = np.stack([np.pad(part, ((0, 0), (0, width - part.shape[1]))) for part in rows])
        return beside(basis, wide), np.linalg.norm(wide, axis=1)


def beside(basis: Array, rows: Array) -> Array:
    """What is left of rows (..., R) or (..., R, K) beside a basis (R, m)."""
    return rows - basis @ (basis.T @ rows)


def _outcome(duel: Duel, truth: Array, block: tuple[Array, Array], signed: bool) -> Outcome:
    """`signed`: the imitator has no negative values; where it would need one it does not imitate at all."""
    columns, length = block
    seen = np.einsum("srk,srk->sk", columns, columns) > _SAME * length**2
    scale = np.where(seen, length, np.inf)
    unit = columns / scale[:, None, :]
    gram = np.einsum("srk,srl->skl", unit, unit)
    values, vectors = np.linalg.eigh(gram)
    along = np.einsum("skl,srk,r->sl", vectors, unit, truth)
    inverse = np.where(values > _SAME, 1 / np.maximum(values, _SAME), 0.0)
    most = float(truth @ truth)
    left = most - np.sum(along**2 * inverse, axis=1)
    found = np.einsum("skl,sl->sk", vectors, along * inverse) / scale
    if signed:
        wrong = found[:, 0] < 0
        left, found = np.where(wrong, most, left), np.where(wrong[:, None], 0.0, found)
    return Outcome(duel, np.maximum(left, 0.0), most, found)
