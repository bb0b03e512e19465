"""Hidden physics, each by formulas of its own: what the library of chebid knows, and what it does not.

An effect is drawn for one arm and one motion (`Scene`), and has a `strength` that `strength.py` sets from the asked
ratio of unexplained torque to noise. It may change the arm (`adapt`), act at every step of the physics (`start` returns
a hook) and change what the drive reports (`report`). Friction acts through MuJoCo's own dry friction wherever it can,
so that a joint at rest really sticks. `law` names the formula; those called `library` are the ones of the effect
library, all others are the same physics by another formula.
"""

from typing import Any

from blind.coupled import CoulombCoupling, ViscousCoupling
from blind.drive import Backlash, Flexibility, RotorInertia, Saturation, TorqueDelay, TorqueGain
from blind.friction import (
    FrictionRipple,
    LoadFriction,
    Offset,
    Presliding,
    Stribeck,
    ViscousAsymmetry,
    ViscousPower,
    ViscousQuadratic,
)
from blind.hidden import Effect, Scene
from blind.position import BaseTilt, CubicSpring, HardStop, Spring, TorqueRipple
from blind.timed import CoulombDrift, ExternalPush, Payload, ViscousDrift
from blind.unknown import Ageing, BentMotor, BetweenJoints, Breathing, LoadViscous, OtherAngleFriction, UnevenViscous

__all__ = ["ALL", "KNOWN", "UNKNOWN", "Effect", "Scene", "describe"]
KNOWN: tuple[type[Effect], ...] = (
    Offset, ViscousAsymmetry, Stribeck, ViscousQuadratic, ViscousPower, LoadFriction, FrictionRipple, TorqueRipple,
    Presliding, ViscousCoupling, CoulombCoupling, CoulombDrift, ViscousDrift, Spring, CubicSpring, HardStop, BaseTilt,
    Payload, RotorInertia, TorqueDelay, TorqueGain, Saturation, Flexibility, Backlash, ExternalPush,
)  # fmt: skip
UNKNOWN: tuple[type[Effect], ...] = (
    UnevenViscous, Breathing, OtherAngleFriction, BetweenJoints, LoadViscous, BentMotor, Ageing,
)  # fmt: skip
ALL: dict[str, type[Effect]] = {effect.name: effect for effect in (*KNOWN, *UNKNOWN)}
# effects of one family look alike: never hidden together
_FAMILIES: dict[str, tuple[type[Effect], ...]] = {
    "curve": (Stribeck, ViscousQuadratic, ViscousPower, Presliding),
    "coupling": (ViscousCoupling, CoulombCoupling),
    "time": (CoulombDrift, ViscousDrift, ExternalPush, Payload),
    "position": (Spring, CubicSpring, HardStop, BaseTilt, TorqueRipple),
    "side": (Offset, ViscousAsymmetry),
    "load": (LoadFriction, FrictionRipple),
    "channel": (RotorInertia, TorqueDelay, TorqueGain, Saturation, Flexibility, Backlash),
}
for _family, _members in _FAMILIES.items():
    for _member in _members:
        _member.family = _family


def describe(effect: Effect) -> dict[str, Any]:
    """For the results table."""
    return {
        "effect": effect.name,
        "joint": effect.joint,
        "law": effect.law,
        "strength": effect.strength,
    } | effect.values
