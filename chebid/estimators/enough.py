"""Are there equations enough? As many equations as parameters are fitted exactly, whatever they say, and the joint that
they belong to would get all the weight.
"""

import numpy as np

from chebid.equations import Rows
from chebid.errors import NoAnswerError
from chebid.robots import Parameter

_RECORD = "record 20 s or more of varied motion; or lower processing: trim and velocity_gate"


def shortage(rows: Rows, parameters: tuple[Parameter, ...]) -> str:
    """Which joint has no more equations than parameters act on it, in words; empty when none has."""
    names = list(dict.fromkeys(p.joint for p in parameters if p.joint))
    for j in range(rows.joints):
        mine = rows.joint == j
        needed = int(np.count_nonzero(rows.W[mine].any(axis=0)))
        count = min(int(np.count_nonzero(mine)), round(rows.noise[j].equations))
        if count <= needed and needed > 0:
            joint = names[j] if len(names) == rows.joints else j + 1
            return f"joint {joint} has {count} independent equations for the {needed} parameters that act on it"
    return ""


def too_few(short: str) -> NoAnswerError:
    """The error for a `shortage`."""
    return NoAnswerError(f"the log is too short: between its ends and above its gate {short}", hint=_RECORD)


def lost_rank_by(short: str, err: NoAnswerError) -> NoAnswerError:
    """The loss of rank of equations of which there is a `shortage`."""
    return NoAnswerError(err.message, hint=f"{short}: {_RECORD}", place=err.place)
