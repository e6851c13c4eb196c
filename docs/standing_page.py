"""The published table: who stands where in a suite, from the results of a run.

    python docs/standing_page.py runs/evaluation-full/results.json

Writes `standing.md` beside this file and its picture, `figures/suite.png`. `make standing` trains,
measures and writes all of it.
"""

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from reflexarc_pictures.rendering import render_results
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.metrics.figures import figures_of
from reflexarc_sim_bridge.evaluation.protocol.results import Agent, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards
from reflexarc_trainer.config.presets import PRESETS

PAGE = Path(__file__).parent / "standing.md"
PICTURE = "figures/suite.png"
COLOURS = "appearance"
"""The family whose worlds differ in colours alone."""


def main(path: Path) -> None:
    """Write the page and its picture."""
    results = Results.from_json(json.loads(path.read_text()))
    cards = score_cards(results)
    grouped = {member for card in cards if len(card.members) > 1 for member in card.members}
    shown = [card for card in cards if card.members[0] not in grouped or len(card.members) > 1]
    shown.sort(key=lambda card: -card.headline.value)
    render_results(path, PAGE.parent / PICTURE)
    PAGE.write_text(_page(results, shown), encoding="utf-8")


def _page(results: Results, cards: Sequence[ScoreCard]) -> str:
    settings = [s for s in Setting if any(card.setting == s for card in cards)]
    parts = [_introduction(results)]
    for setting in settings:
        chosen = [card for card in cards if card.setting == setting]
        parts += [_standings(results, chosen, setting), _answer(chosen), _families(chosen)]
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
            f"| {place} | `{_name(card)}` | {_score(card)} | {card.worst_family} {worst:.2f} "
            f"| {contacts} | {figures['switches_per_s']:.2f} | {area} | {_eye(own)} | {own.tuned} |"
        )
    return "\n".join(lines) + "\n"


def _answer(cards: Sequence[ScoreCard]) -> str:
    """Who is first, where our best preset stands, and both without what ranges need not fear."""
    names = [_short(card) for card in cards]
    ours = next((c for c in cards if _short(c).split("@")[0].rpartition("-")[0] in PRESETS), None)
    ours = ours or next((c for c in cards if _short(c).split("@")[0] in PRESETS), None)
    if ours is None:
        return ""
    first, place = cards[0], names.index(_short(ours)) + 1
    return (
        f"First is `{names[0]}`; the best of our presets is `{_short(ours)}`, in place {place} of "
        f"{len(cards)}. Who sees ranges sees no colours, so that `{COLOURS}` asks nothing of it: "
        f"without that family they have {_without(first):.3f} and {_without(ours):.3f}.\n"
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
        lines.append(f"| `{_short(card)}` | {' | '.join(words)} |")
    return "\n".join(lines) + "\n"


def _eye(agent: Agent) -> str:
    """Of the words of a contract's eye those that tell eyes apart."""
    told = dict(word.split("=") for word in agent.eye.replace(",", "").split() if "=" in word)
    degrees = math.degrees(float(told["fov_rad"]))
    eyes = f"{told['eyes']} × {told['rays']}" if told["eyes"] != "1" else told["rays"]
    words = f"{eyes} rays, {degrees:.0f}°, {float(told['range_m']):g} m, {told['shading']}"
    return f"{words}, as ranges" if agent.eye.endswith("ranges") else words


def _name(card: ScoreCard) -> str:
    seeds = f", {len(card.members)} seeds" if len(card.members) > 1 else ""
    return f"{_short(card)}{seeds}"


def _short(card: ScoreCard) -> str:
    if len(card.members) > 1:
        return card.name.partition(",")[0]
    return card.name.replace("/policy.onnx", "").rpartition("/")[2]


def _score(card: ScoreCard) -> str:
    low, high = card.headline.low, card.headline.high
    interval = "" if low is None or high is None else f" [{low:.3f}, {high:.3f}]"
    return f"{card.headline.value:.3f}{interval}"


if __name__ == "__main__":
    if len(sys.argv) != 2:
        raise UsageError("expected the path of results.json")
    main(Path(sys.argv[1]))
