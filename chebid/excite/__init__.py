"""Exciting trajectories: the criterion of eq. 23 (`criterion`), two families of motions (`points`, `fourier`) under the
limits of the model file (`limits`), and the search for the best of them (`search`).

Separating trajectories (`separate`): rivals (`rivals`) as strong as a log or the noise says (`size`), how well each
could pass for another on a motion (`contest`), and that as the objective of the same search (`separation`).
"""

from chebid.excite.search import KINDS, Excitation, excite
from chebid.excite.separate import ENOUGH, Pair, Separated, Size, separate
from chebid.excite.table import trajectory_table

__all__ = ["ENOUGH", "KINDS", "Excitation", "Pair", "Separated", "Size", "excite", "separate", "trajectory_table"]
