"""The library of physical effects. Friction of the first model, a missing effect, a user's own: all are effects.

One file per kind (`friction`, `position`, `transmission`, `coupling`, `drift`, `channel`, `load`); `user` for formulas,
`plugins` for other packages, `forward` for what they do in a simulation. A new effect is one class, in one of these.
"""

from chebid.effects.channel import find_limit, saturated
from chebid.effects.effect import ArmEffect, Derived, Effect, JointEffect
from chebid.effects.hyper import Extent, Hyper, setting
from chebid.effects.library import LIBRARY, all_effects, describe_library, make_effects, specify
from chebid.effects.motion import Motion
from chebid.effects.units import Units

__all__ = [
    "LIBRARY",
    "ArmEffect",
    "Derived",
    "Effect",
    "Extent",
    "Hyper",
    "JointEffect",
    "Motion",
    "Units",
    "all_effects",
    "describe_library",
    "find_limit",
    "make_effects",
    "saturated",
    "setting",
    "specify",
]
