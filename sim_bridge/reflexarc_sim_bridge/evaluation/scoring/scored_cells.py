"""All cells of one contender in one setting, scored: as measured, and in every draw of worlds."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.results import CellFacts, ResultRow, Results
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import (
    Interval,
    contacts_interval,
    contacts_per_100m,
    mean_farthest_m,
    percentile_interval,
    row_dispersion,
    speed_mps,
)
from reflexarc_sim_bridge.evaluation.scoring.cell_score import LEAST_WAY, between
from reflexarc_sim_bridge.evaluation.scoring.robustness import robustness_area
from reflexarc_sim_bridge.evaluation.scoring.world_draws import world_draws

_BLIND, _ORACLE = "blind", "oracle"


@dataclass(frozen=True)
class CellScore:
    """One contender in one cell."""

    family: str
    tier: str
    counts: bool
    score: Interval
    """Its value is NaN where there is nothing to tell."""
    contacts_per_100m: Interval | None
    """None for a body that turns."""
    farthest_m: Interval | None
    """Of a body that turns: how far it gets before its first contact, or in the given time."""
    dispersion: float | None
    """Variance over mean of the contacts of the worlds."""


@dataclass(frozen=True)
class ScoredCells:
    """The rows of one contender in one setting, and the results that they are from."""

    results: Results
    rows: Sequence[ResultRow]
    turns: bool

    @cached_property
    def worlds(self) -> int:
        """How many worlds each cell has."""
        return len(self.rows[0].array("agents"))

    @cached_property
    def families(self) -> tuple[str, ...]:
        """Those with cells that count and tell something, in the suite's order."""
        return tuple(dict.fromkeys(facts.family for facts, _ in self._counted))

    @cached_property
    def cells(self) -> list[CellScore]:
        """Figures and scores of all cells."""
        return [self._cell(*each) for each in zip(self._facts, self.rows, strict=True)]

    def family_scores(self, family: str) -> Floats:
        """Mean over the cells that count, in each draw: (1 + draws,)."""
        chosen = [scores for facts, scores in self._counted if facts.family == family]
        means: Floats = np.stack(chosen).mean(axis=0)
        return means

    def robustness_area(self) -> float:
        """See `robustness.py`; NaN where there is none."""
        scores = {row.key: float(s[0]) for row, s in zip(self.rows, self._scores, strict=True)}
        return robustness_area(self.rows, lambda row: scores[row.key])

    @cached_property
    def _facts(self) -> list[CellFacts]:
        by_cell = {(facts.family, facts.tier): facts for facts in self.results.cells}
        return [by_cell[row.family, row.tier] for row in self.rows]

    @cached_property
    def _draws(self) -> Floats:
        return world_draws(self.worlds)

    @cached_property
    def _scores(self) -> list[Floats]:
        return [self._scores_in(row) for row in self.rows]

    @cached_property
    def _counted(self) -> list[tuple[CellFacts, Floats]]:
        return [
            (facts, scores)
            for facts, scores in zip(self._facts, self._scores, strict=True)
            if facts.counts and np.isfinite(scores[0])
        ]

    def _scores_in(self, row: ResultRow) -> Floats:
        blind, oracle = (self.results.limit(row, name) for name in (_BLIND, _ORACLE))
        assert blind is not None
        own, of_blind = self._figure(row), self._figure(blind)
        best = np.zeros_like(own) if oracle is None else self._figure(oracle)
        scores = between(own, of_blind, best)
        if not self.turns:
            stands = speed_mps(row, self._draws) < LEAST_WAY * speed_mps(blind, self._draws)
            scores = np.where(stands, -1.0, scores)
        # A draw of worlds in which nothing can be told says what all of them say.
        return np.where(np.isfinite(scores), scores, scores[0])

    def _figure(self, row: ResultRow) -> Floats:
        return (mean_farthest_m if self.turns else contacts_per_100m)(row, self._draws)

    def _cell(self, facts: CellFacts, row: ResultRow) -> CellScore:
        score = percentile_interval(self._scores[self.rows.index(row)], self.worlds)
        contacts = None if self.turns else contacts_interval(row, self._draws)
        greatest = None
        if self.turns:
            greatest = percentile_interval(mean_farthest_m(row, self._draws), self.worlds)
        dispersion = None if self.turns else row_dispersion(row)
        return CellScore(
            facts.family, facts.tier, facts.counts, score, contacts, greatest, dispersion
        )
