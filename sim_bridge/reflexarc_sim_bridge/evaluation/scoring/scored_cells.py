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
    cost,
    mean_greatest_m,
    percentile_interval,
    row_dispersion,
)
from reflexarc_sim_bridge.evaluation.scoring.cell_score import cell_score
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
    greatest_m: Interval | None
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

    def perturbed_and_nominal(self) -> tuple[list[float], list[float]]:
        """Scores of the cells that are worse versions of others, and of those others."""
        by_name = {
            f"{facts.family}/{facts.tier}": float(scores[0])
            for facts, scores in zip(self._facts, self._scores, strict=True)
        }
        perturbed = {f"{facts.family}/{facts.tier}": facts.perturbs for facts in self._facts}
        by_name = {name: score for name, score in by_name.items() if np.isfinite(score)}
        pairs = {
            mine: theirs
            for mine, theirs in perturbed.items()
            if mine in by_name and theirs in by_name
        }
        nominal = dict.fromkeys(pairs.values())
        return [by_name[mine] for mine in pairs], [by_name[theirs] for theirs in nominal]

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
        own = cost(row, self._draws, turns=self.turns)
        blind, oracle = (self._limit(row, name) for name in (_BLIND, _ORACLE))
        assert blind is not None
        least = self._least_cost(row) if oracle is None else oracle
        scores = cell_score(own, blind, least)
        # A draw of worlds in which nothing can be told says what all of them say.
        return np.where(np.isfinite(scores), scores, scores[0])

    def _limit(self, row: ResultRow, name: str) -> Floats | None:
        limit = self.results.limit(row, name)
        return None if limit is None else cost(limit, self._draws, turns=self.turns)

    def _least_cost(self, row: ResultRow) -> Floats:
        """What nothing can undercut: no contact; or straight ahead for all the time."""
        if not self.turns:
            return np.zeros(len(self._draws))
        return -(self._draws @ row.array("straight_m")) / (self._draws @ row.array("agents"))

    def _cell(self, facts: CellFacts, row: ResultRow) -> CellScore:
        score = percentile_interval(self._scores[self.rows.index(row)], self.worlds)
        contacts = None if self.turns else contacts_interval(row, self._draws)
        greatest = None
        if self.turns:
            greatest = percentile_interval(mean_greatest_m(row, self._draws), self.worlds)
        dispersion = None if self.turns else row_dispersion(row)
        return CellScore(
            facts.family, facts.tier, facts.counts, score, contacts, greatest, dispersion
        )
