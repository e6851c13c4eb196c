"""The reference field's figures as tables and as plain values."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from rich.table import Table

from reflexarc_runtime.words.shown import plain

if TYPE_CHECKING:
    from reflexarc_sim_bridge.evaluation.reference_field import FieldScore
    from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval


def plain_score(score: "FieldScore", blind: float) -> dict[str, float | None]:
    """A score as plain values; beside it its share of what an agent does that never steers."""
    return {
        "contacts_per_100m": score.contacts_per_100m,
        "low": score.low,
        "high": score.high,
        "share_of_blind": score.contacts_per_100m / blind if blind else None,
        "contacts": score.contacts,
        "distance_m": score.distance_m,
        "agents": score.agents,
        "guarded": score.guarded,
        "stuck": score.stuck,
    }


def plain_distance(distance: "Interval") -> dict[str, float | None]:
    """A distance as plain values."""
    return {"farthest_m": distance.value, "low": distance.low, "high": distance.high}


def contacts_table(scores: "Mapping[str, FieldScore]", where: str, *, guarded: bool) -> Table:
    """Contacts per 100 m."""
    table = Table(title=f"{where}: contacts per 100 m", title_justify="left")
    more = ("guarded", "stuck") if guarded else ()
    for name in ("policy", "contacts / 100 m", "95 % interval", "of blind", *more):
        table.add_column(name, justify="left" if name == "policy" else "right")
    blind = scores["blind"].contacts_per_100m
    for name, score in scores.items():
        interval = f"{score.low:.2f} – {score.high:.2f}"
        share = f"{score.contacts_per_100m / blind:.2f}" if blind else "–"
        did = (f"{score.guarded:.1%}", f"{score.stuck:.1%}") if guarded else ()
        table.add_row(plain(name), f"{score.contacts_per_100m:.2f}", interval, share, *did)
    return table


def distances_table(distances: "Mapping[str, Interval]", where: str) -> Table:
    """How far bodies that turn get."""
    title = f"{where}: greatest distance before the first contact, within 60 s"
    table = Table(title=title, title_justify="left")
    for name in ("policy", "distance, m", "95 % interval"):
        table.add_column(name, justify="left" if name == "policy" else "right")
    for name, distance in distances.items():
        table.add_row(plain(name), f"{distance.value:.1f}", interval_words(distance, 1))
    return table


def interval_words(interval: "Interval", digits: int) -> str:
    """Its two ends, or a dash."""
    if interval.low is None or interval.high is None:
        return "–"
    return f"{interval.low:.{digits}f} – {interval.high:.{digits}f}"
