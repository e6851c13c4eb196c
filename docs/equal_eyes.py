"""The published table's part at equal eyes: who sees the same, each kind ranked by itself.

Those with the very eye of our best preset are ranked among themselves, and so are those that get
the same eye's distances in metres, for which no world is dim and no background bright. The
difference of our best preset to the best rival of either kind stands family by family.
"""

from collections.abc import Sequence

from standing_words import (
    AS_RANGES,
    best_of_ours,
    eye_of,
    is_ours,
    name_of,
    score_of,
    short_name,
    with_interval,
)

from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard
from reflexarc_sim_bridge.evaluation.scoring.score_difference import score_differences


def equal_eyes(results: Results, cards: Sequence[ScoreCard]) -> str:
    """The section, or nothing where none of our presets is measured.

    Args:
        results: that all cards are of.
        cards: of one setting, the best first.
    """
    agents = {agent.name: agent for agent in results.agents}
    walking = [card for card in cards if not agents[card.members[0]].turns]
    ours = best_of_ours(walking)
    if ours is None:
        return ""
    eye = eye_of(agents[ours.members[0]])
    same = [card for card in walking if eye_of(agents[card.members[0]]) == eye]
    ranges = [card for card in walking if eye_of(agents[card.members[0]]) == eye + AS_RANGES]
    parts = [
        f"### At equal eyes\n\n{eye}, as a retina:\n",
        _ranked(same),
        "The same eye's distances in metres, for which no world is dim and no background bright:\n",
        _ranked(ranges),
    ]
    rivals = [best for kind in (same, ranges) if (best := _best_rival(kind)) is not None]
    if rivals:
        parts.append(_differences(results, ours, rivals))
    return "\n".join(parts)


def _best_rival(cards: Sequence[ScoreCard]) -> ScoreCard | None:
    return next((card for card in cards if not is_ours(card)), None)


def _ranked(cards: Sequence[ScoreCard]) -> str:
    lines = ["| | who | score [95 %] | worst family |", "|---|---|---|---|"]
    for place, card in enumerate(cards, start=1):
        worst = f"{card.worst_family} {card.families[card.worst_family].value:.2f}"
        lines.append(f"| {place} | `{name_of(card)}` | {score_of(card)} | {worst} |")
    return "\n".join(lines) + "\n"


def _differences(results: Results, ours: ScoreCard, rivals: Sequence[ScoreCard]) -> str:
    """Our score less that of each rival, family by family."""
    headers = [f"less `{name_of(rival)}` [95 %]" for rival in rivals]
    found = [score_differences(results, ours, rival) for rival in rivals]
    lines = [
        f"The score of our best preset, `{name_of(ours)}`, less that of the best rival of either "
        "kind: above 0 ours is the better. Both are measured in the same worlds, and every draw of "
        f"worlds is taken of both. Intervals: ours {ours.note}; "
        + "; ".join(f"`{short_name(rival)}` {rival.note}" for rival in rivals)
        + ".\n",
        f"| | `{name_of(ours)}` | {' | '.join(headers)} |",
        "|---" * (2 + len(rivals)) + "|",
        _row("all", ours.headline, [headline for headline, _ in found]),
    ]
    for family, score in ours.families.items():
        lines.append(_row(family, score, [families.get(family) for _, families in found]))
    told = [
        f"Against `{short_name(rival)}` {_told(families)}"
        for rival, (_, families) in zip(rivals, found, strict=True)
    ]
    return "\n".join(lines) + "\n\n" + " ".join(told) + "\n"


def _row(name: str, own: Interval, differences: Sequence[Interval | None]) -> str:
    words = ["–" if each is None else with_interval(each, "+") for each in differences]
    return f"| {name} | {own.value:.3f} | {' | '.join(words)} |"


def _told(families: dict[str, Interval]) -> str:
    """Where the interval leaves no doubt which of the two is the better."""
    better = [n for n, d in families.items() if d.low is not None and d.low > 0.0]
    worse = [n for n, d in families.items() if d.high is not None and d.high < 0.0]
    level = len(families) - len(better) - len(worse)
    return (
        f"it is better in {_list(better)} and worse in {_list(worse)}; in {level} of "
        f"{len(families)} families the interval holds 0."
    )


def _list(names: Sequence[str]) -> str:
    return ", ".join(names) or "none"
