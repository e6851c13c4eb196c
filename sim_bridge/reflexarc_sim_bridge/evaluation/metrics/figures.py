"""The table of figures: what each is called, its unit, and how it follows from sums.

Sums of many worlds, and of many rows, are added before a figure is made of them: a figure of a cell
is no mean over its worlds. A figure that does not exist, such as a reaction distance where nothing
threatened, is NaN.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.clearances import percentile
from reflexarc_sim_bridge.evaluation.metrics.lateral import divergence_bits, mirror_bits
from reflexarc_sim_bridge.evaluation.metrics.survival import restricted_mean
from reflexarc_sim_bridge.evaluation.metrics.switches import entropy_bits
from reflexarc_sim_bridge.evaluation.metrics.track import Floats

Totals = Mapping[str, Floats]
"""Sums, added over all worlds: () or (bins,) each."""


class Better(StrEnum):
    """Which way is better."""

    LOWER = "lower"
    HIGHER = "higher"
    NEITHER = ""
    """It describes and does not judge."""


@dataclass(frozen=True)
class MetricFigure:
    """One figure."""

    of: Callable[[Totals], float]
    """From totals."""
    unit: str
    better: Better
    title: str
    """What it is, in one line."""


class HasSums(Protocol):
    """A row of results."""

    @property
    def sums(self) -> Mapping[str, Any]:
        """By the name of the sum: one value, or one row of values, a world."""


def totals_of(rows: Iterable[HasSums]) -> dict[str, Floats]:
    """The sums of rows, added over their worlds.

    Args:
        rows: of one contender: histograms of actions must be of the same actions.
    """
    totals: dict[str, Floats] = {}
    for row in rows:
        for name, values in row.sums.items():
            added: Floats = np.asarray(values, np.float64).sum(axis=0)
            totals[name] = totals[name] + added if name in totals else added
    return totals


def figures_of(rows: Iterable[HasSums]) -> dict[str, float]:
    """All figures of some rows taken together, by name; NaN where there is none."""
    totals = totals_of(rows)
    if not totals:
        return dict.fromkeys(FIGURES, math.nan)
    return {name: figure.of(totals) for name, figure in FIGURES.items()}


def _ratio(above: str, below: str, factor: float = 1.0) -> Callable[[Totals], float]:
    def of(totals: Totals) -> float:
        whole = float(totals[below])
        return factor * float(totals[above]) / whole if whole > 0.0 else math.nan

    return of


def _avoidance(totals: Totals) -> float:
    unavoided = float(totals["met_threats"] + totals["surprises"])
    threats = float(totals["threats"] + totals["surprises"])
    return 1.0 - unavoided / threats if threats > 0.0 else math.nan


def _smoothness(totals: Totals) -> float:
    jerk, time_s = float(totals["jerk"]), float(totals["jerk_time_s"])
    if time_s == 0.0:
        return math.nan
    return -math.log(jerk / time_s) if jerk > 0.0 else math.inf


_L, _H, _N = Better.LOWER, Better.HIGHER, Better.NEITHER
_Of = Callable[[Totals], float]

_TABLE: tuple[tuple[str, _Of, str, Better, str], ...] = (
    (
        "contacts_per_free_path",
        _ratio("contacts", "free_paths"),
        "/ℓ₀",
        _L,
        "collisions per mean free path; 1 for a body that never steers",
    ),
    (
        "contacts_per_100m",
        _ratio("contacts", "way_m", 100.0),
        "/100 m",
        _L,
        "collisions per 100 m of way",
    ),
    (
        "free_way",
        lambda totals: restricted_mean(totals["way_lives"]),
        "ℓ₀",
        _H,
        "way without a collision, in mean free paths, restricted mean up to 10",
    ),
    (
        "free_time",
        lambda totals: restricted_mean(totals["time_lives"]),
        "ℓ₀/v",
        _H,
        "time without a collision, in mean free paths over speed, restricted mean up to 10",
    ),
    (
        "threat_avoidance",
        _avoidance,
        "",
        _H,
        "share of threats that did not become a collision",
    ),
    (
        "threatened",
        _ratio("threat_time_s", "time_s"),
        "",
        _L,
        "share of the time with less than 2(R/w + τ) to the collision ahead",
    ),
    (
        "within_1s",
        _ratio("soon_time_s", "time_s"),
        "",
        _L,
        "share of the time with less than 1 s to the collision ahead",
    ),
    (
        "least_ahead_s",
        _ratio("least_ahead_s", "threats"),
        "s",
        _H,
        "least time to the collision ahead in a threat, mean over threats",
    ),
    (
        "reacts",
        _ratio("reactions", "threats"),
        "",
        _H,
        "share of threats in which it steers at all",
    ),
    (
        "reaction_m",
        _ratio("reaction_m", "reactions"),
        "m",
        _H,
        "distance to the obstacle ahead when it first steers in a threat",
    ),
    (
        "reaction_limits",
        _ratio("reaction_limits", "reactions"),
        "v(τ + R/w)",
        _H,
        "the same as a multiple of the least distance at which one can still get out of the way",
    ),
    (
        "clearance_p5",
        lambda totals: percentile(totals["clearance_steps"], 0.05),
        "R",
        _H,
        "clearance that 5 % of the time lies below",
    ),
    (
        "close",
        _ratio("close_time_s", "time_s"),
        "",
        _L,
        "share of the time closer than 0.5 R",
    ),
    (
        "least_clearance",
        _ratio("least_clearance", "agents"),
        "R",
        _H,
        "least clearance of an agent, 0 if it met anything, mean over agents",
    ),
    (
        "switches_per_s",
        _ratio("switches", "time_s"),
        "/s",
        _L,
        "changes of action a second",
    ),
    (
        "reversals_per_s",
        _ratio("reversals", "time_s"),
        "/s",
        _L,
        "changes from left to right or back a second",
    ),
    (
        "short_holds",
        _ratio("short_holds", "holds"),
        "",
        _L,
        "share of actions that are held for one step only",
    ),
    (
        "action_bits",
        lambda totals: entropy_bits(totals["action_steps"]),
        "bit",
        _N,
        "entropy of the actions",
    ),
    (
        "aside_per_ahead",
        _ratio("aside_m", "ahead_m"),
        "",
        _L,
        "way aside for each metre ahead, Σ|Δy|/Σ|Δx|",
    ),
    (
        "curvature",
        _ratio("turned_rad", "turned_way_m"),
        "rad/m",
        _L,
        "mean |curvature| of a turner's path",
    ),
    (
        "smoothness",
        _smoothness,
        "",
        _H,
        "−ln of the dimensionless jerk of a turner's path, over 1 s",
    ),
    (
        "edge_index",
        _ratio("edge_time_s", "sided_time_s"),
        "",
        _N,
        "time within 2R of a side, 1 for who is everywhere alike",
    ),
    (
        "place_divergence",
        lambda totals: divergence_bits(totals["place_steps"]),
        "bit",
        _L,
        "divergence of its places across from uniform",
    ),
    (
        "mirror_places",
        lambda totals: mirror_bits(totals["place_steps"]),
        "bit",
        _L,
        "divergence of its places across from their mirror image",
    ),
    (
        "mirror_actions",
        lambda totals: mirror_bits(totals["side_steps"]),
        "bit",
        _L,
        "divergence of right, stay and left from left, stay and right",
    ),
    (
        "farthest_m",
        _ratio("farthest_m", "agents"),
        "m",
        _H,
        "greatest distance from the start before the first contact or the end (turners)",
    ),
)

FIGURES: Mapping[str, MetricFigure] = MappingProxyType(
    {name: MetricFigure(of, unit, better, title) for name, of, unit, better, title in _TABLE}
)
"""By name, in the order of the metrics."""
