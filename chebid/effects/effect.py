"""What a physical effect is to the rest of chebid: torques per parameter, names, units, ranges, and a sentence.

A new effect is a frozen dataclass with its hyper-parameters as fields (`hyper.setting`), `columns`, `units`, and, if
it has hyper-parameters, the values worth trying (`choices`). Everything else has a default.
"""

import dataclasses
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from chebid.effects.hyper import Extent, Hyper, extent
from chebid.effects.motion import Motion
from chebid.effects.units import Units
from chebid.robots import Array, Parameter, Robot

Grid = list[dict[str, Any]]


@dataclass(frozen=True)
class Derived:
    """A quantity computed from parameters: the rest position of a spring, the stiffness of a gear."""

    name: str
    value: float
    unit: str


@dataclass(frozen=True)
class Effect:
    """Base of all effects. `joint` counts from 0, None for the whole arm.

    `name` in files; `formula` and `sentence` for a person; `kind`: friction, position, transmission, channel, load,
    time or user. `symbols`, one per parameter; those in `positive` cannot be negative in nature. `linear`: the
    columns are the effect and not only its signature. `memory`: a column at one instant depends on others. `alike`:
    effects that look much the same on many motions.
    """

    joint: int | None
    name: ClassVar[str] = ""
    sentence: ClassVar[str] = ""
    formula: ClassVar[str] = ""
    kind: ClassVar[str] = "friction"
    symbols: ClassVar[tuple[str, ...]] = ()
    positive: ClassVar[tuple[str, ...]] = ()
    alike: ClassVar[tuple[str, ...]] = ()
    linear: ClassVar[bool] = True
    whole_arm: ClassVar[bool] = False
    memory: ClassVar[bool] = False

    # what it is -----------------------------------------------------------------------------------------------------

    def units(self, units: Units) -> tuple[str, ...]:
        """Unit of each parameter."""
        raise NotImplementedError

    def block(self, motion: Motion) -> Array:
        """(N, J, k): the torque on every joint per unit of each parameter."""
        raise NotImplementedError

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        """Name, joint and unit of each parameter."""
        raise NotImplementedError

    @property
    def needs_model(self) -> bool:
        """Whether the columns are made of the model's own torque: `motion.tau`, `motion.rigid`."""
        return False

    @property
    def one_way(self) -> bool:
        """Whether it has one parameter, which cannot be negative in nature."""
        return len(self.symbols) == 1 and set(self.symbols) == set(self.positive)

    @property
    def once(self) -> bool:
        """Whether it happens at one instant of one log, so that other logs know nothing of it."""
        return False

    @property
    def signs(self) -> tuple[int, ...]:
        """Joints the direction of whose motion matters: where they are slow, the effect is uncertain."""
        return ()

    @property
    def forward(self) -> str:
        """Name of its compiled forward form, empty if it has none."""
        return self.name

    def rows(self, count: int) -> tuple[int, ...]:
        """Which of the `count` joints have a torque from it."""
        return tuple(range(count)) if self.joint is None else (self.joint,)

    def bind(self, robot: Robot) -> Self:
        """The effect on a certain robot; most need not know it."""
        return self

    def derived(self, values: Sequence[float], rotary: tuple[bool, ...]) -> tuple[Derived, ...]:
        """What else the values of the parameters mean."""
        return ()

    # its torque -----------------------------------------------------------------------------------------------------

    def on(self, motion: Motion) -> Array:
        """(N, R, k): `block` on the joints of `rows`, seen from the whole motion where the past matters."""
        whole = motion.whole
        if not self.memory or whole is None:
            return self._on(motion)
        return whole.remember(self, lambda: self._on(whole))[motion.piece]

    def _on(self, motion: Motion) -> Array:
        return self.block(motion)[:, list(self.rows(motion.q.shape[1]))]

    # its hyper-parameters -------------------------------------------------------------------------------------------

    @classmethod
    def hypers(cls) -> dict[str, Hyper]:
        """Hyper-parameters by name, in the order of `vector`."""
        return {f.name: f.metadata["hyper"] for f in dataclasses.fields(cls) if "hyper" in f.metadata}

    @classmethod
    def defaults(cls) -> dict[str, Any]:
        """Values of the hyper-parameters that need not be given."""
        fields = (f for f in dataclasses.fields(cls) if "hyper" in f.metadata)
        return {f.name: f.default for f in fields if f.default is not dataclasses.MISSING}

    @property
    def hyper(self) -> dict[str, Any]:
        """Its values of the hyper-parameters."""
        return {name: getattr(self, name) for name in self.hypers()}

    def vector(self) -> Array:
        """The hyper-parameters as numbers (H,), for the forward form; what is not given is -inf."""
        return np.array([-math.inf if value is None else float(value) for value in self.hyper.values()])

    def settings(self, joints: tuple[str, ...]) -> dict[str, Any]:
        """The hyper-parameters as they stand in a model file."""
        kinds = self.hypers()
        given = {name: value for name, value in self.hyper.items() if value is not None}
        return {
            name: joints[value] if kinds[name].unit == "joint" else _plain(value, kinds[name])
            for name, value in given.items()
        }

    @classmethod
    def choices(cls, range_: Extent) -> dict[str, Iterable[Any]]:
        """Values worth trying for each hyper-parameter on a joint that moves like this."""
        return {}

    @classmethod
    def grid(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> Grid:
        """Settings worth trying on a motion (its trusted part), `gate` being the slowest speed used on the joint."""
        choices = cls.choices(motion_extent(motion, joint, gate))
        plain = [[v.item() if isinstance(v, np.generic) else v for v in values] for values in choices.values()]
        return [dict(zip(choices, values, strict=True)) for values in itertools.product(*plain)]

    @classmethod
    def refinable(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> dict[str, tuple[float, float]]:
        """Bounds for the hyper-parameters that are continuous: somewhat beyond the grid, within what is allowed."""
        grid, kinds, out = cls.grid(motion, joint, gate), cls.hypers(), {}
        for name, hyper in kinds.items():
            values = sorted({entry[name] for entry in grid if entry.get(name) is not None})
            if hyper.continuous and values:
                out[name] = hyper.clip(*_beyond(values, hyper))
        return out

    @classmethod
    def candidates(cls, motion: Motion, joint: int | None, gate: float = 0.0) -> list[Self]:
        """The effect with each of the settings of `grid`."""
        return [cls(joint, **entry) for entry in cls.grid(motion, joint, gate)]


@dataclass(frozen=True)
class JointEffect(Effect):
    """An effect on the torque of one joint: `columns` is all that it has to give."""

    joint: int

    def columns(self, motion: Motion) -> Array:
        """(N, k): the torque on its joint per unit of each parameter."""
        raise NotImplementedError

    def block(self, motion: Motion) -> Array:
        columns = self.columns(motion)
        out = np.zeros((len(columns), motion.q.shape[1], columns.shape[1]))
        out[:, self.joint] = columns
        return out

    def _on(self, motion: Motion) -> Array:
        own = type(self).block is JointEffect.block
        return self.columns(motion)[:, None, :] if own else super()._on(motion)

    def label(self, symbol: str) -> str:
        """Names as in the paper: the symbol and the number of the joint, from 1."""
        return f"{symbol}{self.joint + 1}"

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        units = self.units(Units(rotary[self.joint]))
        named = zip(self.symbols, units, strict=True)
        return tuple(Parameter(self.label(symbol), joints[self.joint], unit) for symbol, unit in named)


@dataclass(frozen=True)
class ArmEffect(Effect):
    """An effect on the whole arm: `block` is what it has to give."""

    joint: None = None
    kind = "load"
    whole_arm = True

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        named = zip(self.symbols, self.units(Units(rotary[-1])), strict=True)
        return tuple(Parameter(symbol, None, unit) for symbol, unit in named)


def column(values: Array) -> Array:
    """(N,) as (N, 1)."""
    return values[:, None]


def motion_extent(motion: Motion, joint: int | None, gate: float) -> Extent:
    """What a motion covers on a joint; on the whole arm, that of its fastest joint."""
    at = int(np.argmax(np.abs(motion.dq).max(axis=0))) if joint is None else joint
    return extent(motion.t, motion.q[:, at], motion.dq[:, at], gate)


def _beyond(values: list[float], hyper: Hyper) -> tuple[float, float]:
    """Bounds around values: by a factor for what is a scale, else by a step."""
    if hyper.low == 0:
        return values[0] / 2, values[-1] * 2
    step = (values[-1] - values[0]) / max(len(values) - 1, 1) or 0.5 * abs(values[0]) or 1.0
    return values[0] - step, values[-1] + step


def _plain(value: Any, hyper: Hyper) -> float | int:
    return int(value) if hyper.whole else float(value)
