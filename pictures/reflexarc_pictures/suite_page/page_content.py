"""What a page is made of: results, their scores, and what only a new drive can show."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

from reflexarc_pictures.suite_page.moment import Moment
from reflexarc_sim_bridge.evaluation.protocol.results import Agent, ResultRow, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard


@dataclass(frozen=True)
class Entry:
    """One line of the leaderboard: a contender, or a preset with several seeds."""

    place: int
    """1 for the best headline score in the page's first setting."""
    name: str
    agents: tuple[Agent, ...]
    cards: dict[Setting, ScoreCard]

    @property
    def turns(self) -> bool:
        """Whether its body turns: it has no contacts per 100 m."""
        return any(agent.turns for agent in self.agents)


@dataclass(frozen=True)
class PageContent:
    """Everything that a page shows."""

    results: Results
    cards: Sequence[ScoreCard]
    """Of all contenders and presets, in all settings: see `score_cards`."""
    suite: Suite | None = None
    """The protocol; None: the page says only what the results say of it."""
    moments: Sequence[Moment] = field(default_factory=tuple)
    command: str = ""
    """What measures all this again."""

    @cached_property
    def settings(self) -> list[Setting]:
        """Those that were measured; the page shows the first where it shows only one."""
        return list(dict.fromkeys(card.setting for card in self.cards))

    @cached_property
    def entries(self) -> list[Entry]:
        """From the best headline score to the least; equal ones by name."""
        by_name: dict[str, dict[Setting, ScoreCard]] = {}
        for card in self.cards:
            by_name.setdefault(card.name, {})[card.setting] = card
        agents = {agent.name: agent for agent in self.results.agents}
        ordered = sorted(by_name.items(), key=lambda item: (self._worth(item[1]), item[0]))
        return [
            Entry(place, name, tuple(agents[each] for each in _members(cards)), cards)
            for place, (name, cards) in enumerate(ordered, 1)
        ]

    def rows(self, entry: Entry, setting: Setting) -> list[ResultRow]:
        """The rows of an entry in a setting; those of a preset are of all its seeds."""
        names = {agent.name for agent in entry.agents}
        return [
            row for row in self.results.rows if row.contender in names and row.setting is setting
        ]

    @cached_property
    def families(self) -> list[str]:
        """In the suite's order."""
        return list(dict.fromkeys(cell.family for cell in self.results.cells))

    def _worth(self, cards: dict[Setting, ScoreCard]) -> tuple[bool, float]:
        card = cards.get(self.settings[0])
        return card is None, -card.headline.value if card else 0.0


def _members(cards: dict[Setting, ScoreCard]) -> tuple[str, ...]:
    return next(iter(cards.values())).members
