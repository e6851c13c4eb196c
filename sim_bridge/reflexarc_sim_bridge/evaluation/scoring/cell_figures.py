"""The figure of a row: contacts per 100 m, or how far a body that turns gets.

A body that turns has no progress along x to count contacts over: see `metrics/farthest.py`.
"""

from dataclasses import dataclass

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow
from reflexarc_sim_bridge.evaluation.scoring.poisson_interval import (
    dispersion,
    may_be_poisson,
    poisson_interval,
)

LEAST_M = 1e-6
"""Agents that all stand have no rate; this one keeps it a number."""
_PER_M = 100.0


@dataclass(frozen=True)
class Interval:
    """A figure with its 95 % interval."""

    value: float
    low: float | None
    """None: no interval."""
    high: float | None


def contacts_per_100m(row: ResultRow, draws: Floats) -> Floats:
    """In each draw of worlds: (draws, worlds) → (draws,)."""
    progress_m = np.maximum(draws @ row.array("progress_m"), LEAST_M)
    rates: Floats = _PER_M * (draws @ row.array("contacts")) / progress_m
    return rates


def mean_farthest_m(row: ResultRow, draws: Floats) -> Floats:
    """Restricted mean of the greatest distance: (draws, worlds) → (draws,)."""
    means: Floats = (draws @ row.array("farthest_m")) / (draws @ row.array("agents"))
    return means


def speed_mps(row: ResultRow, draws: Floats) -> Floats:
    """Progress over time: (draws, worlds) → (draws,)."""
    speeds: Floats = (draws @ row.array("progress_m")) / (draws @ row.array("time_s"))
    return speeds


def contacts_interval(row: ResultRow, draws: Floats) -> Interval:
    """Contacts per 100 m: exact Poisson where the dispersion is near 1 or nothing happened.

    Elsewhere that of the bootstrap over worlds; where worlds are too few for one, none.
    """
    contacts, progress_m = row.array("contacts"), float(row.array("progress_m").sum())
    rates = contacts_per_100m(row, draws)
    if may_be_poisson(contacts) and progress_m > LEAST_M:
        ends = poisson_interval(round(float(contacts.sum())))
        return Interval(float(rates[0]), *(_PER_M * end / progress_m for end in ends))
    return percentile_interval(rates, len(contacts))


def percentile_interval(figures: Floats, drawn_from: int) -> Interval:
    """The interval of a bootstrap: the first figure is that of all, the others are draws'.

    Args:
        figures: (1 + draws,).
        drawn_from: how many things were drawn from; of fewer than two there is no interval.
    """
    value = float(figures[0])
    known = figures[1:][np.isfinite(figures[1:])]
    if drawn_from < 2 or not len(known):
        return Interval(value, None, None)
    low, high = np.percentile(known, (2.5, 97.5))
    return Interval(value, float(low), float(high))


def row_dispersion(row: ResultRow) -> float | None:
    """Variance over mean of the contacts of its worlds."""
    return dispersion(row.array("contacts"))
