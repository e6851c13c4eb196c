"""Targets of a study: bounds that the figures of a cell should keep, as tables of its TOML file.

[[target]]
cell = "paper"
mean_at_most = 0.45                # bounds the interquartile mean
each_at_most = 0.7                 # bounds every seed's figure

If a seed diverged or is missing, its cell misses every bound.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from reflexarc_runtime.config.checks import require
from reflexarc_sim_bridge.evaluation.scoring.statistics import interquartile_mean


@dataclass(frozen=True)
class Target:
    """Bounds on the figures of one cell."""

    cell: str
    """Name of the cell."""
    mean_at_most: float = math.inf
    mean_at_least: float = -math.inf
    each_at_most: float = math.inf
    each_at_least: float = -math.inf

    def __post_init__(self) -> None:
        bounds = (self.mean_at_most, self.mean_at_least, self.each_at_most, self.each_at_least)
        require(any(map(math.isfinite, bounds)), "cell", "a target with a bound", "none")
        require(not any(map(math.isnan, bounds)), "cell", "numbers for bounds", "nan")

    def missed(self, figures: Sequence[float], wanted: int) -> list[str]:
        """The bounds that do not hold, in words.

        Args:
            figures: of the seeds that have one.
            wanted: number of seeds of the study.
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
        """The bounds in words."""
        bounds = (
            ("mean ≤", self.mean_at_most),
            ("mean ≥", self.mean_at_least),
            ("each seed ≤", self.each_at_most),
            ("each seed ≥", self.each_at_least),
        )
        return ", ".join(f"{words} {bound:g}" for words, bound in bounds if math.isfinite(bound))
