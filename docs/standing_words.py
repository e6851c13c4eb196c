"""How the published table names contenders, and which of them are ours."""

import math
from collections.abc import Sequence

from reflexarc_sim_bridge.evaluation.protocol.results import Agent
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard
from reflexarc_trainer.config.presets import PRESETS

AS_RANGES = ", as ranges"
"""Of who gets metres in place of a retina, from the same eye."""


def eye_of(agent: Agent) -> str:
    """Of the words of a contract's eye those that tell eyes apart."""
    told = dict(word.split("=") for word in agent.eye.replace(",", "").split() if "=" in word)
    degrees = math.degrees(float(told["fov_rad"]))
    eyes = f"{told['eyes']} × {told['rays']}" if told["eyes"] != "1" else told["rays"]
    words = f"{eyes} rays, {degrees:.0f}°, {float(told['range_m']):g} m, {told['shading']}"
    return f"{words}{AS_RANGES}" if agent.eye.endswith("ranges") else words


def name_of(card: ScoreCard) -> str:
    """Short, with the number of seeds."""
    seeds = f", {len(card.members)} seeds" if len(card.members) > 1 else ""
    return f"{short_name(card)}{seeds}"


def short_name(card: ScoreCard) -> str:
    """Of a preset its group, of a file no more than tells it apart."""
    if len(card.members) > 1:
        return card.name.partition(",")[0]
    return card.name.replace("/policy.onnx", "").rpartition("/")[2]


def is_ours(card: ScoreCard) -> bool:
    """Whether one of our presets trained it: `reflex-0` and `reflex@36bf6063` are."""
    group = short_name(card).split("@")[0]
    return group in PRESETS or group.rpartition("-")[0] in PRESETS


def best_of_ours(cards: Sequence[ScoreCard]) -> ScoreCard | None:
    """The best of our presets; None where none is measured."""
    ours = [card for card in cards if is_ours(card)]
    return max(ours, key=lambda card: card.headline.value, default=None)


def score_of(card: ScoreCard) -> str:
    """The headline with its interval."""
    return with_interval(card.headline, "")


def with_interval(figure: Interval, sign: str) -> str:
    """A figure to three places with its interval, if it has one.

    Args:
        figure: such as a score or a difference of two.
        sign: "+" shows that of positive figures, "" does not.
    """
    if figure.low is None or figure.high is None:
        return f"{figure.value:{sign}.3f}"
    return f"{figure.value:{sign}.3f} [{figure.low:{sign}.3f}, {figure.high:{sign}.3f}]"
