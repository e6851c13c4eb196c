"""The memory of a policy: the values that it carries from one input to the next."""

import math
import struct
from dataclasses import dataclass
from functools import partial

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import ContractError

MAX_MEMORY = 4096
"""Values of a memory: every tick records them."""

_require = partial(require, error=ContractError)


@dataclass(frozen=True)
class StateSpec:
    """Size and start value of a memory; by default there is none.

    The graph has an input `state` float32 [N, size] and an output `state_next` of the same shape.
    """

    size: int = 0
    """Values; 0: no memory."""
    start: tuple[float, ...] = ()
    """What it holds before the first input, float32; empty: zeros."""

    def __post_init__(self) -> None:
        _require(0 <= self.size <= MAX_MEMORY, "state.size", f"0 to {MAX_MEMORY}", self.size)
        count = len(self.start)
        _require(count in (0, self.size), "state.start", f"0 or {self.size} values", count)
        exact = all(map(_is_float32, self.start))
        _require(exact, "state.start", "finite float32 values", "others")

    @property
    def start_value(self) -> tuple[float, ...]:
        """What it holds before the first input: (size,)."""
        return self.start or (0.0,) * self.size


def _is_float32(value: float) -> bool:
    try:
        return math.isfinite(value) and struct.unpack("<f", struct.pack("<f", value))[0] == value
    except OverflowError:
        return False
