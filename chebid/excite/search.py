"""`excite`: the best of many optimised motions."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from chebid.dynamics import Dynamics, make_dynamics
from chebid.errors import NoAnswerError, Place, UsageError
from chebid.excite.criterion import Criterion, Score
from chebid.excite.descent import Objective
from chebid.excite.fourier import Fourier
from chebid.excite.limits import Limits, make_limits
from chebid.excite.points import Points
from chebid.model import Model
from chebid.projection.threads import single
from chebid.robots import Array

KINDS = ("points", "fourier")
_MOST = 1000  # samples at which the search evaluates the criterion
_TRIED = 20  # random motions per start, of which the best is improved
_ITERATIONS = 200
_CRAWL = 0.005  # of the largest velocity: what is slower hardly counts, and identification leaves it out
Progress = Callable[[int, int, float], None]
Family = Points | Fourier


@dataclass(frozen=True)
class Excitation:
    """An exciting trajectory: t (N,) s, q, dq, ddq (N, J); its score, that of the best random motion (`before`), the
    median of those, and the share of each limit that it uses: `used` (3, J) of position, velocity, acceleration.

    Of a motion between points: `points` (M + 1, J), `durations` (M,) s of the moves; None for Fourier series.
    """

    t: Array
    q: Array
    dq: Array
    ddq: Array
    score: Score
    before: Score
    median_before: float
    used: Array
    limits: Limits
    points: Array | None
    durations: Array | None
    starts: int


@single
def excite(
    model: Model,
    *,
    duration: float = 8.0,
    moves: int = 9,
    kind: str = "points",
    rate: float = 100.0,
    seed: int = 0,
    starts: int = 8,
    information: float = 1.2,
    progress: Progress | None = None,
) -> Excitation:
    """Optimise a motion of the robot of a model file under its limits, on the criterion of eq. 23.

    `duration` s; `moves`: moves between points, or harmonics; `rate` Hz, at which W is sampled; `starts`: optimisations
    from different random motions, each the best of 20; `information`: see `criterion`. `progress` is called with
    (done, starts, best criterion). On one thread, so that the same call gives the same motion to the last digit; on
    another kind of processor, whose linear algebra rounds differently, another motion that is as good.
    Raises UsageError for what cannot be, NoAnswerError when no motion tells the parameters apart.
    """
    limits, dynamics = make_limits(model), make_dynamics(model)
    check(duration, moves, kind, rate, starts)
    if not 0 <= information <= 1e3:
        raise UsageError(f"information {information} is no weight", hint="1.2 is usual, 0 is eq. 23 alone")
    t = instants(duration, rate)
    step, gate = int(np.ceil(len(t) / _MOST)), _CRAWL * limits.velocity
    search = Criterion(dynamics, t[::step], float(np.sqrt(len(t) / len(t[::step]))), information, gate)
    family = make_family(limits, float(t[-1]), moves, kind)
    found = search_best(search, family, np.random.default_rng(seed), starts, progress)
    if found is None:
        raise NoAnswerError(
            "no motion tells all parameters of this model apart",
            hint="remove effects that cannot be told from others, or allow more moves, or wider limits",
            place=Place(file=str(model.path)),
        )
    return told(found, family, dynamics, t, starts)


def instants(duration: float, rate: float) -> Array:
    """(N,) s."""
    return np.arange(round(duration * rate) + 1) / rate


def make_family(limits: Limits, duration: float, moves: int, kind: str, uneven: bool = False) -> Family:
    """The motions of a kind; `uneven`: see `Points`."""
    return Points(limits, duration, moves, uneven) if kind == "points" else Fourier(limits, duration, moves)


@dataclass
class Found:
    """The best motion of a search, and the random motion with the best criterion; criteria of all random ones."""

    best: Array
    first: Array
    tried: list[float]


def told(found: Found, family: Family, dynamics: Dynamics, t: Array, starts: int) -> Excitation:
    """What a search found, at the instants t (N,) s, scored by eq. 23."""
    whole = Criterion(dynamics, t)
    motion = family.motion(found.best, t)
    points, durations = family.split(found.best) if isinstance(family, Points) else (None, None)
    return Excitation(
        t,
        q=motion[0],
        dq=motion[1],
        ddq=motion[2],
        score=whole.score(motion),
        before=whole.score(family.motion(found.first, t)),
        median_before=float(np.median(found.tried)),
        used=family.limits.used(family.motion(found.best, np.linspace(0, t[-1], 20 * len(t)))),
        limits=family.limits,
        points=points,
        durations=durations,
        starts=starts,
    )


def search_best(
    search: Objective,
    family: Family,
    random: np.random.Generator,
    starts: int,
    progress: Progress | None,
    iterations: int = _ITERATIONS,
) -> Found | None:
    """Improve the best of 20 random motions, `starts` times. None when all of them are of no use."""
    best, best_value, first, first_value = None, np.inf, None, np.inf
    tried: list[float] = []
    for done in range(1, starts + 1):
        motions = [family.random(random) for _ in range(_TRIED)]
        values = [search.value(family.motion(x, search.t)) for x in motions]
        tried += values
        start = motions[int(np.argmin(values))]
        if min(values) < first_value:
            first, first_value = start, min(values)
        found = family.improve(search, start, iterations) if min(values) < np.inf else start
        value = search.objective(family.motion(found, search.t))[0]
        if value < best_value:
            best, best_value = found, value
        if progress and best is not None:
            progress(done, starts, search.value(family.motion(best, search.t)))
    return None if best is None or first is None else Found(best, first, tried)


def check(duration: float, moves: int, kind: str, rate: float, starts: int) -> None:
    """Raise UsageError for numbers that allow no motion."""
    if kind not in KINDS:
        raise UsageError(f"kind {kind!r} is unknown", hint=f"choose one of: {', '.join(KINDS)}")
    least = 1 if kind == "points" else 2
    if moves < least:
        raise UsageError(f"moves {moves} is below {least}", hint="9 is usual")
    if starts < 1:
        raise UsageError(f"starts {starts} is below 1", hint="8 is usual")
    if not (0 < duration <= 1e5 and 0 < rate <= 1e5):
        raise UsageError(f"duration {duration} s at {rate} Hz is no motion", hint="such as 8 s at 100 Hz")
    if duration * rate < 10 * moves:
        raise UsageError(
            f"{moves} moves in {duration * rate:.0f} samples", hint="allow more time, fewer moves or a higher rate"
        )
