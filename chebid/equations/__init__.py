"""Log + model -> rows: the over-determined system Y = W theta + rho of eq. 20, gated, trimmed and filtered."""

from chebid.equations.build import Band, choose_band, measured_rows, project_columns
from chebid.equations.filtered import FilterSettings, filtered_rows
from chebid.equations.gate import choose_gate, moving
from chebid.equations.neighbour import neighbour_floor
from chebid.equations.repeats import repeat_floor
from chebid.equations.rows import JointNoise, Rows

__all__ = [
    "Band",
    "FilterSettings",
    "JointNoise",
    "Rows",
    "choose_band",
    "choose_gate",
    "filtered_rows",
    "measured_rows",
    "moving",
    "neighbour_floor",
    "project_columns",
    "repeat_floor",
]
