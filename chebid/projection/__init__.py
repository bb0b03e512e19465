"""Projection of sampled signals on orthogonal polynomials: samples -> `Series`, with any derivative.

`plan` decides (degree, window, penalty), an `Operator` carries it out, a `Series` evaluates and differentiates itself.
"""

from chebid.projection.choose import Setting, from_bandwidth, plan
from chebid.projection.layout import Layout
from chebid.projection.operator import Operator
from chebid.projection.plan import FITS, Plan
from chebid.projection.series import Series
from chebid.projection.signal import Projection, project

__all__ = ["FITS", "Layout", "Operator", "Plan", "Projection", "Series", "Setting", "from_bandwidth", "plan", "project"]
