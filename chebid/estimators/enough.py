"""Are there equations enough? Before anything is solved: as many equations as parameters are fitted exactly, whatever
they say, and the joint that they belong to would get all the weight.
"""

import numpy as np

from chebid.equations import Rows
from chebid.errors import NoAnswerError
from chebid.robots import Parameter


def require_enough(rows: Rows, parameters: tuple[Parameter, ...]) -> None:
    """Raise NoAnswerError for a joint with no more equations than parameters act on it."""
    names = list(dict.fromkeys(p.joint for p in parameters if p.joint))
    for j in range(rows.joints):
        mine = rows.joint == j
        needed = int(np.count_nonzero(rows.W[mine].any(axis=0)))
        count = min(int(np.count_nonzero(mine)), round(rows.noise[j].equations))
        if count <= needed and needed > 0:
            joint = names[j] if len(names) == rows.joints else j + 1
            raise NoAnswerError(
                f"the log is too short: joint {joint} has {count} independent equations between its ends and above its "
                f"gate, and {needed} parameters act on it",
                hint="record 20 s or more of varied motion; or lower processing: trim and velocity_gate",
            )
