"""Are there equations enough? As many equations as parameters are fitted exactly, whatever they say, and the joint that
they belong to would get all the weight.
"""

import numpy as np

from chebid.equations import Rows
from chebid.errors import NoAnswerError
from chebid.robots import Parameter

_RECORD = "record 20 s or more of varied motion; or lower processing: trim and velocity_gate"


def shortage(rows: Rows, parameters: tuple[Parameter, ...]) -> str:
    """Which joint has no more equations than parameters of its own, in words; empty when none has.

    Parameters of other joints that act on it as well are left to their equations.
    """
    names = list(dict.fromkeys(p.joint for p in parameters if p.joint))
    if len(names) != rows.joints:
        return ""
    for j, name in enumerate(names):
        mine = rows.joint == j
        own = np.array([p.joint == name for p in parameters])
        needed = int(np.count_nonzero(rows.W[mine].any(axis=0) & own))
        count = min(int(np.count_nonzero(mine)), round(rows.noise[j].equations))
        if count <= needed and needed > 0:
            return f"joint {name} has {count} independent equations for its {needed} parameters"
    return ""


def too_few(short: str) -> NoAnswerError:
    """The error for a `shortage`."""
    return NoAnswerError(f"the log is too short, or its band too narrow: {short}", hint=_RECORD)


def lost_rank_by(short: str, err: NoAnswerError) -> NoAnswerError:
    """The loss of rank of equations of which there is a `shortage`."""
    return NoAnswerError(err.message, hint=f"{err.hint}; {short}: {_RECORD}", place=err.place)
