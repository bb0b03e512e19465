"""A simulated log as a table."""

import numpy as np
import pandas as pd

from chebid.simulate.loop import Simulated

_DIGITS = 9  # significant: encoders and noise are coarser, and files stay small


def simulated_table(log: Simulated, reference: bool = False) -> pd.DataFrame:
    """t, q1.., tau1.. and, if asked for, the commanded positions r1.., rounded to 9 significant digits."""
    named = {"q": log.q, "tau": log.tau} | ({"r": log.reference} if reference else {})
    columns = {
        f"{name}{j + 1}": rounded(values[:, j]) for name, values in named.items() for j in range(values.shape[1])
    }
    return pd.DataFrame({"t": rounded(log.t)} | columns)


def rounded(values: np.ndarray) -> np.ndarray:
    """To 9 significant digits of the largest, so that machines that differ in the last bit write the same file."""
    largest = float(np.abs(values).max(initial=0.0)) or 1.0
    return np.round(values, _DIGITS - 1 - int(np.floor(np.log10(largest)))) + 0.0
