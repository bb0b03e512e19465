"""Units of what an effect's numbers mean on a joint that turns, and on one that slides."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Units:
    """Units of one joint: rad and N.m, or m and N."""

    rotary: bool

    @property
    def position(self) -> str:
        return "rad" if self.rotary else "m"

    @property
    def velocity(self) -> str:
        return f"{self.position}/s"

    @property
    def torque(self) -> str:
        return "N.m" if self.rotary else "N"

    @property
    def inertia(self) -> str:
        return "kg.m^2" if self.rotary else "kg"

    @property
    def wave(self) -> str:
        """Of k in cos(k q): waves per revolution; on a sliding joint rad/m."""
        return "1/rev" if self.rotary else "rad/m"

    @property
    def compliance(self) -> str:
        return "rad/(N.m)" if self.rotary else "m/N"

    def per_velocity(self, power: float = 1) -> str:
        """Torque per velocity to a power: N.m.s/rad, N.s^2/m^2."""
        raised = _raised(power)
        return f"{self.torque}.s{raised}/{self.position}{raised}"

    def per_position(self, power: float = 1) -> str:
        """Torque per position to a power: N.m/rad, N/m^3."""
        return f"{self.torque}/{self.position}{_raised(power)}"

    def named(self, name: str) -> str:
        """A quantity by its name (`position`, `velocity`, ...), or the unit itself (`s`, `1`)."""
        return str(getattr(self, name, name))


def _raised(power: float) -> str:
    return "" if power == 1 else f"^{power:g}"
