"""The published table: who stands where in a suite, from the results of a run.

    python docs/standing_page.py runs/evaluation-full/results.json
    python docs/standing_page.py runs/evaluation-flow-full/results.json --flow

Writes `standing.md` beside this file and its picture, `figures/suite.png`. Those that see by flow
have a run and a section of their own: a call writes its part anew and keeps the other. `make
standing` trains, measures and writes all of it, `make standing-flow` the section.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from equal_eyes import equal_eyes
from standing_words import best_of_ours, eye_of, name_of, score_of, short_name

from reflexarc_pictures.rendering import render_results
from reflexarc_sim_bridge.evaluation.metrics.figures import figures_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND
from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards

PAGE = Path(__file__).parent / "standing.md"
PICTURE = "figures/suite.png"
COLOURS = "appearance"
"""The family whose worlds differ in colours alone."""
HOME = "home"
"""The family of the worlds that flow was made for; it never counts."""
FLOW_HEADING = "## Those that see by flow"


def main(path: Path, *, is_flow: bool = False) -> None:
    """Write the page and its picture, or the section of those that see by flow.

    Args:
        path: `results.json` of a run.
        is_flow: whether it is the run of those.
    """
    results = Results.from_json(json.loads(path.read_text()))
    cards = score_cards(results)
    grouped = {member for card in cards if len(card.members) > 1 for member in card.members}
    shown = [card for card in cards if card.members[0] not in grouped or len(card.members) > 1]
    shown.sort(key=lambda card: -card.headline.value)
    everybody, flow = _parts_of_before()
    if is_flow:
        flow = _flow_section(results, shown)
    else:
        render_results(path, PAGE.parent / PICTURE)
        everybody = _page(results, shown)
    PAGE.write_text("\n".join(part for part in (everybody, flow) if part), encoding="utf-8")


def _parts_of_before() -> tuple[str, str]:
    """What the page says of everybody, and of those that see by flow; empty where nothing is."""
    before = PAGE.read_text(encoding="utf-8") if PAGE.exists() else ""
    everybody, heading, flow = before.partition(FLOW_HEADING)
    return everybody.rstrip("\n") + "\n" if everybody else "", heading + flow


def _flow_section(results: Results, cards: Sequence[ScoreCard]) -> str:
    """Their scores, by a blind agent and an oracle as slow aside as they are; their home."""
    agents = {agent.name: agent for agent in results.agents}
    motions = sorted({agents[card.members[0]].motion for card in cards})
    suite = results.suite.rpartition("-")[0]
    introduction = f"""{FLOW_HEADING}

A run of its own, `make standing-flow SUITE={suite}` (suite `{results.suite}`, reflexarc \
{results.version}), for they move otherwise ({"; ".join(motions)}): what never steers and what is \
possible are of bodies like theirs, and no score here is to be laid beside one above. In \
`{HOME}`, which never counts, contacts per 100 m stand before those of such a body that never \
steers.
"""
    settings = [s for s in Setting if any(card.setting == s for card in cards)]
    parts = [introduction]
    for setting in settings:
        chosen = [card for card in cards if card.setting == setting]
        parts += [_flow_standings(results, chosen, setting), _families(chosen)]
    return "\n".join(parts)


def _flow_standings(results: Results, cards: Sequence[ScoreCard], setting: Setting) -> str:
    tiers = list(dict.fromkeys(cell.tier for cell in results.cells if cell.family == HOME))
    columns = ["", "who", "score [95 %]", "contacts per 100 m", "switches a second"]
    columns += [f"`{tier}`, blind" for tier in tiers]
    lines = [f"| {' | '.join(columns)} |", "|---" * len(columns) + "|"]
    for place, card in enumerate(cards, start=1):
        rows = [r for r in results.rows if r.contender in card.members and r.setting == setting]
        figures = figures_of([row for row in rows if row.family != HOME])
        at_home = [_at_home(results, row) for row in rows if row.family == HOME]
        words = [str(place), f"`{name_of(card)}`", score_of(card)]
        words += [f"{figures[name]:.2f}" for name in ("contacts_per_100m", "switches_per_s")]
        lines.append(f"| {' | '.join([*words, *at_home])} |")
    return "\n".join(lines) + "\n"


def _at_home(results: Results, row: ResultRow) -> str:
    """Contacts per 100 m of a row and of what never steers there."""
    blind = results.limit(row, BLIND)
    rates = [figures_of([each])["contacts_per_100m"] for each in (row, blind) if each is not None]
    return ", ".join(f"{rate:.2f}" for rate in rates)


def _page(results: Results, cards: Sequence[ScoreCard]) -> str:
    settings = [s for s in Setting if any(card.setting == s for card in cards)]
    parts = [_introduction(results)]
    for setting in settings:
        chosen = [card for card in cards if card.setting == setting]
        parts += [_standings(results, chosen, setting), _answer(chosen), _families(chosen)]
        parts += [section] if (section := equal_eyes(results, chosen)) else []
    return "\n".join(parts)


def _introduction(results: Results) -> str:
    return f"""# Who stands where

Suite `{results.suite}`, reflexarc {results.version}; [the procedure](evaluation.md), \
[the earlier systems](baselines.md). Made by `make standing`: the scores are those of the run, in \
their order, whoever is first. 0 is an agent that never steers, 1 what is possible.

![Scores by family]({PICTURE})
"""


def _standings(results: Results, cards: Sequence[ScoreCard], setting: Setting) -> str:
    agents = {agent.name: agent for agent in results.agents}
    lines = [
        f"## At the {setting}'s rate and body\n",
        "| | who | score [95 %] | worst family | contacts per 100 m | switches a second "
        "| robustness | eye | tuned or trained |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for place, card in enumerate(cards, start=1):
        own = agents[card.members[0]]
        rows = [r for r in results.rows if r.contender in card.members and r.setting == setting]
        figures, worst = figures_of(rows), card.families[card.worst_family].value
        area = "–" if card.robustness_area is None else f"{card.robustness_area:.2f}"
        contacts = "–" if own.turns else f"{figures['contacts_per_100m']:.2f}"
        lines.append(
            f"| {place} | `{name_of(card)}` | {score_of(card)} | {card.worst_family} {worst:.2f} "
            f"| {contacts} | {figures['switches_per_s']:.2f} | {area} | {eye_of(own)} "
            f"| {own.tuned} |"
        )
    return "\n".join(lines) + "\n"


def _answer(cards: Sequence[ScoreCard]) -> str:
    """Who is first, where our best preset stands, and both without what ranges need not fear."""
    names = [short_name(card) for card in cards]
    ours = best_of_ours(cards)
    if ours is None:
        return ""
    first, place = cards[0], names.index(short_name(ours)) + 1
    without = " and ".join(f"{_without(card):.3f}" for card in (first, ours))
    return (
        f"First is `{names[0]}`; the best of our presets is `{short_name(ours)}`, in place "
        f"{place} of {len(cards)}. Who sees ranges sees no colours, so that `{COLOURS}` asks "
        f"nothing of it: without that family they have {without}.\n"
    )


def _without(card: ScoreCard) -> float:
    """Mean over the other families."""
    scores = [each.value for name, each in card.families.items() if name != COLOURS]
    return sum(scores) / len(scores)


def _families(cards: Sequence[ScoreCard]) -> str:
    families = list(dict.fromkeys(name for card in cards for name in card.families))
    lines = [f"| | {' | '.join(families)} |", "|---" * (len(families) + 1) + "|"]
    for card in cards:
        scores = [card.families.get(name) for name in families]
        words = ("–" if score is None else f"{score.value:.2f}" for score in scores)
        lines.append(f"| `{short_name(card)}` | {' | '.join(words)} |")
    return "\n".join(lines) + "\n"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, help="results.json of a run")
    parser.add_argument("--flow", action="store_true", help="of those that see by flow")
    return parser.parse_args()


if __name__ == "__main__":
    given = _arguments()
    main(given.results, is_flow=given.flow)
