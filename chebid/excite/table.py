"""An exciting trajectory as a table."""

import numpy as np
import pandas as pd

from chebid.excite.search import Excitation


def trajectory_table(found: Excitation) -> pd.DataFrame:
    """t, q1.., dq1.., ddq1.. to 1e-10 rad (m) and s."""
    columns = {"t": found.t}
    for order, values in (("", found.q), ("d", found.dq), ("dd", found.ddq)):
        columns |= {f"{order}q{j}": np.round(x, 10) + 0.0 for j, x in enumerate(values.T, 1)}
    return pd.DataFrame(columns)
