"""What a physical effect is to the rest of chebid: columns, names, units, and a sentence."""

from dataclasses import dataclass
from typing import ClassVar

from chebid.robots import Array, Parameter


@dataclass(frozen=True)
class Motion:
    """A motion at N instants: t (N,) s; q, dq, ddq (N, J) in rad or m and s; tau (N, J) the model's own torque, if
    known.

    `tau` is predicted, never measured: measured torque inside a regressor fits anything.
    """

    t: Array
    q: Array
    dq: Array
    ddq: Array
    tau: Array | None = None


@dataclass(frozen=True)
class Units:
    """Units of one joint: rad and N.m, or m and N."""

    rotary: bool

    @property
    def position(self) -> str:
        return "rad" if self.rotary else "m"

    @property
    def torque(self) -> str:
        return "N.m" if self.rotary else "N"

    def per_velocity(self, power: int = 1) -> str:
        """Torque per velocity to a power: N.m.s/rad, N.s^2/m^2."""
        raised = "" if power == 1 else f"^{power}"
        return f"{self.torque}.s{raised}/{self.position}{raised}"


@dataclass(frozen=True)
class Effect:
    """Base of all effects: one physical effect on joint number `joint` (from 0), `name` its name in files.

    A subclass gives `columns`, one per parameter of `symbols`, in the torque of that joint (torque = rigid body +
    terms).
    """

    joint: int
    name: ClassVar[str] = ""
    sentence: ClassVar[str] = ""
    symbols: ClassVar[tuple[str, ...]] = ()

    def units(self, units: Units) -> tuple[str, ...]:
        """Unit of each parameter."""
        raise NotImplementedError

    def columns(self, motion: Motion) -> Array:
        """(N, k): the effect's torque on its joint per unit of each parameter."""
        raise NotImplementedError

    def parameters(self, joints: tuple[str, ...], rotary: tuple[bool, ...]) -> tuple[Parameter, ...]:
        """Names as in the paper: the symbol and the number of the joint, from 1."""
        units = self.units(Units(rotary[self.joint]))
        names = (f"{symbol}{self.joint + 1}" for symbol in self.symbols)
        return tuple(Parameter(name, joints[self.joint], unit) for name, unit in zip(names, units, strict=True))
