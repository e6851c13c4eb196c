"""How long the phases of a loop took since somebody listens: sums of what its statuses tell."""

from dataclasses import dataclass, field
from itertools import accumulate

from reflexarc_runtime.messages.spread import Spread

LEAST_BITS, MOST_BITS = 12, 31
"""From 4 µs to 2 s: below it is all in the first bucket, above it in the last."""
BOUNDS_S = tuple((1 << bits) * 1e-9 for bits in range(LEAST_BITS, MOST_BITS + 1))
"""Upper bounds of the buckets, each twice the one before."""


@dataclass
class PhaseTally:
    """Times of one phase, counted in powers of two."""

    counts: list[int] = field(default_factory=lambda: [0] * (len(BOUNDS_S) + 1))
    """One for each bound, and one for what is above all of them."""
    sum_s: float = 0.0

    def add(self, spread: Spread) -> None:
        """Add the times of a period."""
        for bits, count in enumerate(spread.octaves, spread.least_bits):
            self.counts[min(max(bits - LEAST_BITS, 0), len(BOUNDS_S))] += count
        self.sum_s += spread.sum_ns * 1e-9

    @property
    def cumulative(self) -> list[int]:
        """How many times do not exceed each bound; the last: how many there were."""
        return list(accumulate(self.counts))
