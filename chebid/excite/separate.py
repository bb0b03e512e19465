"""`excite --separate`: the motion within the limits on which rival effects look least alike.

What is made large is the smallest E of `contest`, of all pairs of rivals, either being the truth. The settings of an
imitator are those of its grid; at the end they are moved between the values of the grid to where it imitates best, and
the search goes on with those among them (an exchange algorithm; Hettich and Kortanek, SIAM Review 35, 1993).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from chebid.effects import Effect
from chebid.errors import NoAnswerError, Notice
from chebid.excite.contest import Contest, Duel, Outcome, Piece, Truth
from chebid.excite.criterion import Criterion
from chebid.excite.limits import make_limits
from chebid.excite.refine import refine
from chebid.excite.rivals import read_rivals
from chebid.excite.search import Excitation, Found, Progress, check, instants, make_family, search_best, told
from chebid.excite.separation import Separation
from chebid.excite.size import Noise, as_noise
from chebid.excite.task import Task, make_task
from chebid.model import Model
from chebid.robots import Array

ENOUGH = 24.0  # difference of scores from which on a diagnosis tells even effects apart that look alike
_LEAST = 1.0  # below it a motion says nothing
_ITERATIONS = 80
_ROUNDS = 2  # of the exchange
_IMITATED = 1e-7  # share of E without imitator: the imitation is exact


@dataclass(frozen=True)
class Pair:
    """Two rivals; the difference of their scores, on the motion there was `before` and on the new one, whichever of
    them is the truth. `truth` was then hardest to tell, `imitator` came nearest to it.
    """

    rivals: tuple[str, str]
    before: float
    after: float
    truth: Effect
    imitator: Effect


@dataclass(frozen=True)
class Size:
    """How strong a rival was taken to be: its settings, values (k,), and whether a log says so."""

    rival: str
    effect: Effect
    values: Array
    from_log: bool


@dataclass(frozen=True)
class Separated:
    """A separating trajectory. `before`: what it is compared with, `log` or `random` (the best random motion)."""

    excitation: Excitation
    pairs: tuple[Pair, ...]
    before: str
    sizes: tuple[Size, ...]
    noise: Noise
    notices: tuple[Notice, ...]

    @property
    def least(self) -> float:
        """Score difference of the pair that is hardest to tell apart."""
        return min(pair.after for pair in self.pairs)


def separate(
    model: Model,
    names: Sequence[str],
    *,
    logs: Sequence[Path] = (),
    duration: float = 20.0,
    moves: int = 14,
    kind: str = "points",
    rate: float = 100.0,
    seed: int = 0,
    starts: int = 4,
    progress: Progress | None = None,
) -> Separated:
    """The motion of a model's robot, within its limits, on which rivals (`effect` or `effect:joint`) differ most.

    `logs`: those that the model was fitted on, where they do not lie beside it; other options as in `excite`. Raises
    UsageError for what cannot be, NoAnswerError for rivals that no motion, or none that was found, tells apart.
    """
    limits, rivals = make_limits(model), read_rivals(names, model)
    check(duration, moves, kind, rate, starts)
    t = instants(duration, rate)
    family = make_family(limits, float(t[-1]), moves, kind, uneven=True)
    random = np.random.default_rng(seed)
    task = make_task(model, rivals, logs, family, t, random)
    search, notices = _search(task)
    show = (lambda done, total, value: progress(done, total, value**2 / 2)) if progress else None
    found = search_best(search, family, random, starts, show, _ITERATIONS)
    if found is None:
        raise _inseparable(task)
    found, search = _exchange(found, search, task)
    pairs = _pairs(found, search, task)
    short = _short(min(pair.after for pair in pairs), task)
    scored = Criterion(task.dynamics, t).score(family.motion(found.first, t)).value
    return Separated(
        told(replace(found, tried=[scored]), family, task.dynamics, t, starts),
        pairs,
        "log" if task.fitted else "random",
        tuple(Size(rivals[o.rival].label, o.effect, o.values, o.sized) for o in search.contest.truths),
        task.noise,
        (*notices, *short),
    )


# who is to be told from whom ----------------------------------------------------------------------------------------


def _search(task: Task) -> tuple[Separation, list[Notice]]:
    """The rivals as they may be, and the duels that some motion can decide, as the objective of a search."""
    settings = tuple(task.settings(rival) for rival in task.rivals)
    repeat = len(task.t) / len(task.searched)
    blank = Contest(task.dynamics, (), settings, ())
    search = Separation(blank, task.searched, task.noise.deviation, task.gate, repeat)
    pieces = [search.piece(trial.t, np.stack([trial.q, trial.dq, trial.ddq])) for trial in task.trials]
    truths: list[Truth] = []
    for number, rival in enumerate(task.rivals):
        seen = task.fitted.truths(number, rival) if task.fitted else []
        truths += seen or as_noise(number, blank, pieces)
    duels = tuple(Duel(i, b) for i, truth in enumerate(truths) for b in range(len(settings)) if b != truth.rival)
    contest = replace(blank, truths=tuple(truths), duels=duels)
    contest = contest.with_settings([(truth.rival, truth.effect) for truth in truths])
    decided = tuple(o.duel for o in contest.outcomes(pieces) if o.left.min() > _IMITATED * o.most)
    contest = replace(contest, duels=decided)
    return replace(search, contest=contest), _one_sided(contest, task)


def _one_sided(contest: Contest, task: Task) -> list[Notice]:
    """Notices of rivals that contain others. Raises NoAnswerError for two that are the same."""
    decided = {(contest.truths[duel.truth].rival, duel.rival) for duel in contest.duels}
    out = []
    for a, b in combinations(range(len(task.rivals)), 2):
        part, whole = task.rivals[a].label, task.rivals[b].label
        if not {(a, b), (b, a)} & decided:
            raise NoAnswerError(
                f"{part} and {whole} say the same on every motion: none tells them apart",
                hint="keep one of the two; what they predict is the same",
                place=task.place,
            )
        if not {(a, b), (b, a)} <= decided:
            part, whole = (part, whole) if (b, a) in decided else (whole, part)
            text = f"{whole} can be all that {part} is: if {part} is missing, only its fewer parameters speak for it"
            out.append(Notice("contained", text))
    return out


# how well -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Imitation:
    """The best one: E, its duel, the imitator."""

    left: float
    duel: Duel
    imitator: Effect


def _imitations(contest: Contest, pieces: Sequence[Piece], task: Task) -> dict[tuple[int, int], _Imitation]:
    """By rivals (truth, imitator): of the truth that is hardest to tell, the imitation with the best settings."""
    hardest: dict[tuple[int, int], Outcome] = {}
    for outcome in contest.outcomes(pieces):
        key = contest.truths[outcome.duel.truth].rival, outcome.duel.rival
        if key not in hardest or outcome.left.min() < hardest[key].left.min():
            hardest[key] = outcome
    return {key: _refined(outcome, contest, pieces, task) for key, outcome in hardest.items()}


def _refined(outcome: Outcome, contest: Contest, pieces: Sequence[Piece], task: Task) -> _Imitation:
    start = contest.settings[outcome.duel.rival][outcome.best]
    left = contest.imitated(outcome.duel, pieces)
    best = refine(start, left, task.pictured, task.gate_of(start.joint))
    return _Imitation(left(best), outcome.duel, best)


def _exchange(found: Found, search: Separation, task: Task) -> tuple[Found, Separation]:
    """Search on from the best motion, with the best imitations on it among the settings."""
    for _ in range(_ROUNDS):
        piece = search.piece(search.t, task.family.motion(found.best, search.t))
        more = [(one.duel.rival, one.imitator) for one in _imitations(search.contest, [piece], task).values()]
        search = replace(search, contest=search.contest.with_settings(more))
        better = task.family.improve(search, found.best, _ITERATIONS)
        before, after = (search.objective(task.family.motion(x, search.t))[0] for x in (found.best, better))
        if after < before:
            found = replace(found, best=better)
    return _not_worse(found, replace(search, t=task.t, repeat=1.0), task), search


def _not_worse(found: Found, whole: Separation, task: Task) -> Found:
    """What was found, unless the best random motion is better on every sample of the record."""
    values = [whole.value(task.family.motion(x, task.t)) for x in (found.best, found.first)]
    return found if values[0] <= values[1] else replace(found, best=found.first)


def _pairs(found: Found, search: Separation, task: Task) -> tuple[Pair, ...]:
    """What separates each pair, on the logs of the fit or the best random motion, and on the motion found."""
    whole = replace(search, t=task.t, repeat=1.0)
    first, best = (whole.piece(task.t, task.family.motion(x, task.t)) for x in (found.first, found.best))
    old = task.fitted.pieces(task.noise.deviation) if task.fitted else [first]
    before, after = (_imitations(search.contest, pieces, task) for pieces in (old, [best]))
    out = []
    for a, b in combinations(range(len(task.rivals)), 2):
        keys = [key for key in ((a, b), (b, a)) if key in after]
        worst = min((after[key] for key in keys), key=lambda one: one.left)
        truth = search.contest.truths[worst.duel.truth].effect
        was = min(before[key].left for key in keys)
        names = task.rivals[a].label, task.rivals[b].label
        out.append(Pair(names, was / 2, worst.left / 2, truth, worst.imitator))
    return tuple(out)


def _short(least: float, task: Task) -> list[Notice]:
    """That one record is not enough. Raises NoAnswerError where it says next to nothing."""
    if least < _LEAST:
        raise _inseparable(task, least)
    if least >= ENOUGH:
        return []
    times = int(np.ceil(ENOUGH / least))
    return [
        Notice("short", f"one such record is not enough to be sure: record it {times} times, or allow more --duration")
    ]


def _inseparable(task: Task, least: float = 0.0) -> NoAnswerError:
    listed = ", ".join(rival.label for rival in task.rivals)
    return NoAnswerError(
        f"no motion was found within the limits that separates {listed}: their scores differ by {least:.2g} at best, "
        f"and {ENOUGH:g} would tell them apart",
        hint="allow more --duration or wider limits, try another --kind, or name fewer rivals",
        place=task.place,
    )
