"""What a suite says of a contender, or of a preset that learned with several seeds.

    cell score       see `cell_score.py`
    family score     mean over the cells that count
    headline         mean over families of the interquartile mean over seeds
    worst family     the least of these interquartile means
    optimality gap   mean over families and seeds of max(0, 1 − score) (rliable)
    robustness area  see `robustness.py`; mean over seeds

The interval of a file is over worlds; that of a preset over training seeds crossed with worlds, and
of three seeds or fewer there is none. Smoothness is no part of any of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval, percentile_interval
from reflexarc_sim_bridge.evaluation.scoring.scored_cells import CellScore, ScoredCells
from reflexarc_sim_bridge.evaluation.scoring.statistics import TRIMMED
from reflexarc_sim_bridge.evaluation.scoring.world_draws import seed_draws

FEWEST_SEEDS = 4
"""Of fewer training seeds there is no interval."""


@dataclass(frozen=True)
class ScoreCard:
    """The scores of one contender, or of one preset, in one setting."""

    name: str
    setting: Setting
    members: tuple[str, ...]
    """Contenders: one, or one for each training seed."""
    headline: Interval
    families: dict[str, Interval]
    """Those with cells that count."""
    worst_family: str
    optimality_gap: float
    robustness_area: float | None
    """None without such a grid, or where the nominal score is no better than blind."""
    note: str
    """What the interval is over, or why there is none."""
    cells: dict[str, list[CellScore]] = field(default_factory=dict)
    """By member; also those that do not count."""


def score_card(
    name: str, setting: Setting, members: Sequence[str], scored: Sequence[ScoredCells]
) -> ScoreCard:
    """The card of one contender, or of several seeds.

    Args:
        name: of the card.
        setting: that of all rows.
        members: names of the contenders.
        scored: their cells, in the same order.

    Raises:
        UsageError: no cell that counts tells anything.
    """
    families = scores_of_seeds(scored)
    if not families:
        raise UsageError(f"{name}: expected a cell that counts, and where blind fails; got none")
    drawn = {family: over_seeds(scores) for family, scores in families.items()}
    count = drawn_from(scored)
    tables = np.stack(list(drawn.values()))
    values = {family: percentile_interval(scores, count) for family, scores in drawn.items()}
    return ScoreCard(
        name=name,
        setting=setting,
        members=tuple(members),
        headline=percentile_interval(tables.mean(axis=0), count),
        families=values,
        worst_family=min(values, key=lambda family: values[family].value),
        optimality_gap=_optimality_gap(np.stack([each[:, 0] for each in families.values()])),
        robustness_area=_robustness_area(scored),
        note=_note(len(scored), scored[0].worlds),
        cells=dict(zip(members, (each.cells for each in scored), strict=True)),
    )


def middle_means(values: Floats) -> Floats:
    """Interquartile means along the first axis: (n, …) → (…)."""
    n = len(values)
    cut = int(TRIMMED * n)
    means: Floats = np.sort(values, axis=0)[cut : n - cut].mean(axis=0)
    return means


def scores_of_seeds(scored: Sequence[ScoredCells]) -> dict[str, Floats]:
    """Scores by family, of those that all seeds have: (seeds, 1 + draws) each."""
    return {
        family: np.stack([each.family_scores(family) for each in scored])
        for family in scored[0].families
        if all(family in each.families for each in scored)
    }


def over_seeds(scores: Floats, stream: int = 0) -> Floats:
    """Interquartile means over drawn seeds, each draw with its worlds: (seeds, draws) → (draws,).

    Seeds and worlds are crossed: all seeds of a draw are measured in the same drawn worlds.

    Args:
        scores: of each seed, in each draw of worlds.
        stream: another one draws other seeds.
    """
    seeds, draws = scores.shape
    chosen = seed_draws(seeds, draws - 1, stream)
    return middle_means(scores[chosen.T, np.arange(draws)])


def drawn_from(scored: Sequence[ScoredCells]) -> int:
    """How many things the interval is drawn from; 0 where there shall be none."""
    if len(scored) == 1:
        return scored[0].worlds
    return len(scored) if len(scored) >= FEWEST_SEEDS else 0


def _note(seeds: int, worlds: int) -> str:
    if seeds == 1:
        return f"over {worlds} worlds" if worlds > 1 else "1 world: no interval"
    if seeds < FEWEST_SEEDS:
        return f"{seeds} seeds: no interval"
    return f"over {seeds} seeds × {worlds} worlds"


def _optimality_gap(scores: Floats) -> float:
    """(families, seeds) → mean of max(0, 1 − score)."""
    return float(np.maximum(0.0, 1.0 - scores).mean())


def _robustness_area(scored: Sequence[ScoredCells]) -> float | None:
    """Mean over the seeds that have one."""
    areas = [area for each in scored if np.isfinite(area := each.robustness_area())]
    return float(np.mean(areas)) if areas else None


def rows_of(rows: Sequence[ResultRow], name: str, setting: Setting) -> list[ResultRow]:
    """The rows of a contender in a setting."""
    return [row for row in rows if (row.contender, row.setting) == (name, setting)]
