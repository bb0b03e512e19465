"""Which effects are candidates: the library and those of other packages, but for the few that cannot be judged."""

from chebid.effects import Effect, all_effects
from chebid.errors import Notice

_NOT = frozenset({"saturation", "motor_coupling"})  # flags samples; a part of the inertia on a SCARA


def candidate_kinds() -> tuple[dict[str, type[Effect]], tuple[Notice, ...]]:
    """Effects by name, and a notice for each of another package that cannot be used."""
    kinds, notices = all_effects()
    return {name: kind for name, kind in kinds.items() if name not in _NOT}, notices
