"""A motion at given instants, and what the model itself says about it."""

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from chebid.robots import Array

_KEPT = 8  # results remembered: a search over hyper-parameters asks for many, each once
T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion at N instants: t (N,) s; q, dq, ddq (N, J) in rad or m and s.

    `tau` (N, J): the model's own torque without the effects that depend on it, `rigid` (P,): the values of the
    robot's parameters, both if known. They are predicted, never measured: measured torque inside a regressor fits
    anything. `whole`: the motion that this one was cut from, `first` its place there; effects that remember the past
    look back.
    """

    t: Array
    q: Array
    dq: Array
    ddq: Array
    tau: Array | None = None
    rigid: Array | None = None
    whole: "Motion | None" = field(default=None, repr=False)
    first: int = 0
    _memory: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def __len__(self) -> int:
        return len(self.t)

    @property
    def start(self) -> float:
        """The first instant of the whole motion, s."""
        return float((self.whole or self).t[0])

    @property
    def piece(self) -> slice:
        """Where this motion lies in `whole`."""
        return slice(self.first, self.first + len(self.t))

    def cut(self, piece: slice) -> "Motion":
        """The samples of a slice (step 1), which remember the rest."""
        start, stop, step = piece.indices(len(self.t))
        assert step == 1, "a motion is cut into runs of samples"
        tau = None if self.tau is None else self.tau[start:stop]
        parts = (self.t[start:stop], self.q[start:stop], self.dq[start:stop], self.ddq[start:stop], tau)
        return Motion(*parts, self.rigid, self.whole or self, self.first + start)

    def with_model(self, tau: Array, rigid: Array) -> "Motion":
        """The same motion with the model's own torque (N, J) and the robot's parameters (P,)."""
        return replace(self, tau=tau, rigid=rigid)

    def remember(self, key: Hashable, make: Callable[[], T]) -> T:
        """`make()`, computed once for a key while it is among the latest."""
        memory = self._memory
        if key in memory:
            memory[key] = memory.pop(key)  # the latest again
        else:
            made = make()
            while len(memory) >= _KEPT:
                del memory[next(iter(memory))]
            memory[key] = made
        return memory[key]
