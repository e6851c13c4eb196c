"""The score of a cell: 0 for an agent that never steers, 1 for what is possible.

    score = clip((C_blind − C) / (C_blind − C_oracle), −1, 1)

C is a cost: contacts per 100 m, or, of a body that turns, the distance that it does not get. Where
no oracle is known its cost counts as the least that there is.
"""

import numpy as np
import numpy.typing as npt

Costs = npt.NDArray[np.float64]


def cell_score(cost: Costs, blind: Costs, oracle: Costs) -> Costs:
    """Scores: NaN where blind is no worse than the oracle, as nothing can be told there.

    Args:
        cost: of a contender: any shape.
        blind: of an agent that never steers, likewise.
        oracle: of one that knows everything, likewise.
    """
    room = blind - oracle
    with np.errstate(divide="ignore", invalid="ignore"):
        scores: Costs = np.where(room > 0.0, np.clip((blind - cost) / room, -1.0, 1.0), np.nan)
    return scores
