"""Elements of a row of constants, one for each agent."""

from typing import Any

import numpy as np
import numpy.typing as npt


def picked(row: npt.NDArray[Any], places: npt.NDArray[np.int64]) -> npt.NDArray[Any]:
    """What stands at each agent's place in a row.

    `row[places]` would do, were it not that a graph cannot be written from it: a plain array does
    not ask its index what it is.

    Args:
        row: (k,).
        places: (n,), each from 0 to k − 1.
    """
    return np.take_along_axis(row[np.newaxis], places[:, np.newaxis], axis=1)[:, 0]
