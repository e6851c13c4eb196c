"""Figures of some rows, from the sums that they have; None where one of these was not measured.

Sums are added over worlds and rows before a ratio is made of them.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.survival import BIN, BINS, survival_curve
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow, Results

MINUS = "\u2212"
NONE = "\u2013"

_LIVES = "way_lives"


@dataclass(frozen=True)
class Ratio:
    """A figure that is one sum over another."""

    above: str
    below: str
    factor: float = 1.0

    def of(self, rows: Sequence[ResultRow]) -> float | None:
        """The figure of some rows together."""
        above, below = total(rows, self.above), total(rows, self.below)
        if above is None or below is None or not below > 0.0:
            return None
        value = self.factor * float(above) / float(below)
        return value if math.isfinite(value) else None


CONTACTS = Ratio("contacts", "progress_m", 100.0)
SWITCHES = Ratio("switches", "time_s")
REVERSALS = Ratio("reversals", "time_s")
EDGES = Ratio("edge_time_s", "sided_time_s")


def total(rows: Sequence[ResultRow], name: str) -> Floats | None:
    """A sum over all worlds of rows; those that have no such sum must be none of them."""
    if not rows or not all(name in row.sums for row in rows):
        return None
    parts = [np.asarray(row.sums[name], np.float64).sum(axis=0) for row in rows]
    if len({part.shape for part in parts}) > 1:
        return None
    added: Floats = np.sum(parts, axis=0)
    return added


def survival(rows: Sequence[ResultRow]) -> tuple[Floats, Floats] | None:
    """Kaplan and Meier's curve: see `metrics/survival.py`.

    Returns:
        Ways in mean free paths, and the share of lives that go on beyond each, as far as any does;
        None where lives were not counted.
    """
    lives = total(rows, _LIVES)
    if lives is None or lives.shape != (2, BINS + 1) or not lives[0, 0] > 0.0:
        return None
    curve = survival_curve(lives)
    known = np.isfinite(curve)
    borders: Floats = BIN * np.arange(BINS + 1, dtype=np.float64)
    return borders[known], curve[known]


def limits_of(results: Results, rows: Sequence[ResultRow], name: str) -> list[ResultRow]:
    """The rows of a limit of some rows: empty where one is missing."""
    found = [results.limit(row, name) for row in rows]
    return [row for row in found if row is not None] if None not in found else []


def number(value: float | None, decimals: int = 2) -> str:
    """A figure as text, a dash where there is none."""
    if value is None or not math.isfinite(value):
        return NONE
    shown = f"{value:.{decimals}f}"
    if not float(shown):
        shown = shown.lstrip("-")
    return shown.replace("-", MINUS)
