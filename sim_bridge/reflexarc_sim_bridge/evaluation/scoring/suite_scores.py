"""Score cards of a suite's results: of each contender, and of each preset with several seeds."""

from collections.abc import Sequence

from reflexarc_sim_bridge.evaluation.protocol.results import Agent, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard, rows_of, score_card
from reflexarc_sim_bridge.evaluation.scoring.scored_cells import ScoredCells


def score_cards(results: Results) -> list[ScoreCard]:
    """All cards, in the order of settings, then contenders; a preset's stand after them."""
    settings = list(dict.fromkeys(row.setting for row in results.rows))
    return [card for setting in settings for card in _cards(results, setting)]


def presets_of(agents: Sequence[Agent]) -> dict[str, list[Agent]]:
    """Contenders of one group whose seeds differ, by the group's name.

    Two of one seed are not two seeds: such a group is none.
    """
    groups: dict[str, list[Agent]] = {}
    for agent in agents:
        if agent.group:
            groups.setdefault(f"{agent.group}, {agent.rate_hz:g} Hz", []).append(agent)
    return {
        name: members
        for name, members in groups.items()
        if len(members) > 1 and len({agent.seed for agent in members}) == len(members)
    }


def _cards(results: Results, setting: Setting) -> list[ScoreCard]:
    scored = {
        agent.name: ScoredCells(results, rows_of(results.rows, agent.name, setting), agent.turns)
        for agent in results.agents
    }
    cards = [score_card(name, setting, [name], [cells]) for name, cells in scored.items()]
    for group, members in presets_of(results.agents).items():
        names = [agent.name for agent in members]
        name = f"{group} ({len(names)} seeds)"
        cards.append(score_card(name, setting, names, [scored[each] for each in names]))
    return cards
