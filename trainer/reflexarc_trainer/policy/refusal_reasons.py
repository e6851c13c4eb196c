"""Why two computations of a network differ: the reason that a refused export is given.

Which one it is follows from the rounding bound: a difference below it is what float32 does with
these numbers; one above it is no rounding, whatever the weights are.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.arrays import QValues

_LARGE = 10.0
"""Q-values from which on a smaller unit helps: near 1 the tolerance does not shrink with them."""


@dataclass(frozen=True)
class Refusing:
    """The reasons for a network of a rounding bound."""

    bound: float
    """Of what float32 gets wrong, times max(1, |value|); infinite if none is known."""

    def rounded(self, apart: float, q_values: QValues) -> str:
        """Why a backend that rounds otherwise lies so far off.

        Args:
            apart: the difference, times max(1, |value|).
            q_values: what the reference says.
        """
        if not (np.isfinite(q_values).all() and math.isfinite(apart)):
            return not_finite(q_values)
        if apart > self.bound:
            return f"float32 can be off by {self.bound:.2g} at most, so an operator is at fault"
        return (
            "float32 cannot compute it more exactly, for its Q-values are what large numbers leave "
            f"when they cancel out, or jump{_smaller_unit(q_values)}"
        )

    def translated(self, apart: float, q_values: QValues) -> str:
        """Why the file and its original differ."""
        if not (np.isfinite(q_values).all() and math.isfinite(apart)):
            return not_finite(q_values)
        return "more than rounding explains: the original computes something else than its graph"

    def grown(self, apart: float, q_values: QValues) -> str:
        """Why sequences drift apart."""
        if not (np.isfinite(q_values).all() and math.isfinite(apart)):
            return not_finite(q_values)
        return "the memory makes rounding grow from tick to tick: let it forget more of what it had"


def not_finite(q_values: QValues) -> str:
    """Why values are infinite or no numbers."""
    what = "NaN" if np.isnan(q_values).any() else "infinite"
    return (
        f"its values are not finite ({what}): such numbers are among its weights, it divides by 0, "
        "or float32 ends (3.4e38)"
    )


def _smaller_unit(q_values: QValues) -> str:
    size = float(np.median(np.abs(q_values)))
    if size < _LARGE:
        return ""
    return (
        f"; Q-values of {size:.2g} in a smaller unit would pass: divide them by {size:.0e}, which "
        "changes no decision"
    )
