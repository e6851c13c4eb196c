"""How much better one card scores than another, family by family: paired in the same worlds.

Each draw of the bootstrap takes one set of worlds for both, so what a world makes hard for either
of them is no part of the difference. Training seeds are drawn for each apart.
"""

import numpy as np

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval, percentile_interval
from reflexarc_sim_bridge.evaluation.scoring.score_card import (
    ScoreCard,
    drawn_from,
    over_seeds,
    rows_of,
    scores_of_seeds,
)
from reflexarc_sim_bridge.evaluation.scoring.scored_cells import ScoredCells


def score_differences(
    results: Results, card: ScoreCard, other: ScoreCard
) -> tuple[Interval, dict[str, Interval]]:
    """Score of a card less that of another: the headline, and each family that both have.

    Args:
        results: that both cards are of.
        card: whose better scores are above 0.
        other: in the same setting.

    Raises:
        UsageError: no family is scored for both.
    """
    sides = [_scored(results, each) for each in (card, other)]
    ours, theirs = (
        {name: over_seeds(scores, stream) for name, scores in scores_of_seeds(side).items()}
        for stream, side in enumerate(sides)
    )
    drawn: dict[str, Floats] = {name: ours[name] - theirs[name] for name in ours if name in theirs}
    if not drawn:
        raise UsageError(f"expected families that {card.name} and {other.name} share, got none")
    count = min(drawn_from(side) for side in sides)
    headline: Floats = np.stack(list(drawn.values())).mean(axis=0)
    return percentile_interval(headline, count), {
        name: percentile_interval(differences, count) for name, differences in drawn.items()
    }


def _scored(results: Results, card: ScoreCard) -> list[ScoredCells]:
    turns = {agent.name: agent.turns for agent in results.agents}
    return [
        ScoredCells(results, rows_of(results.rows, name, card.setting), turns[name])
        for name in card.members
    ]
