"""Exciting trajectories: the criterion of eq. 23 (`criterion`), two families of motions (`points`, `fourier`) under the
limits of the model file (`limits`), and the search for the best of them (`search`).
"""

from chebid.excite.search import KINDS, Excitation, excite
from chebid.excite.table import trajectory_table

__all__ = ["KINDS", "Excitation", "excite", "trajectory_table"]
