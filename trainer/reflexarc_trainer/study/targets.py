"""What a study is expected to show: bounds on the figure of a cell.

[[target]]
cell = "paper"
mean_at_most = 0.45                # of the interquartile mean
each_at_most = 0.7                 # of every seed

A seed that diverged, or is missing, misses every bound of its cell.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from reflexarc_runtime.config.checks import require
from reflexarc_sim_bridge.evaluation.statistics import interquartile_mean


@dataclass(frozen=True)
class Target:
    """Bounds on one cell."""

    cell: str
    """Its name."""
    mean_at_most: float = math.inf
    mean_at_least: float = -math.inf
    each_at_most: float = math.inf
    each_at_least: float = -math.inf

    def __post_init__(self) -> None:
        bounds = (self.mean_at_most, self.mean_at_least, self.each_at_most, self.each_at_least)
        require(any(map(math.isfinite, bounds)), "cell", "a target with a bound", "none")
        require(not any(map(math.isnan, bounds)), "cell", "numbers for bounds", "nan")

    def missed(self, figures: Sequence[float], wanted: int) -> list[str]:
        """In words, which bounds do not hold.

        Args:
            figures: of the seeds that there are.
            wanted: how many seeds the study has.
        """
        if len(figures) < wanted:
            return [f"{wanted - len(figures)} of {wanted} seeds have no figure"]
        mean, low, high = interquartile_mean(figures), min(figures), max(figures)
        checks = (
            (mean <= self.mean_at_most, f"mean {mean:.3g}, expected ≤ {self.mean_at_most:g}"),
            (mean >= self.mean_at_least, f"mean {mean:.3g}, expected ≥ {self.mean_at_least:g}"),
            (high <= self.each_at_most, f"a seed has {high:.3g}, expected ≤ {self.each_at_most:g}"),
            (low >= self.each_at_least, f"a seed has {low:.3g}, expected ≥ {self.each_at_least:g}"),
        )
        return [words for holds, words in checks if not holds]

    @property
    def words(self) -> str:
        """What is expected."""
        bounds = (
            ("mean ≤", self.mean_at_most),
            ("mean ≥", self.mean_at_least),
            ("each seed ≤", self.each_at_most),
            ("each seed ≥", self.each_at_least),
        )
        return ", ".join(f"{words} {bound:g}" for words, bound in bounds if math.isfinite(bound))
