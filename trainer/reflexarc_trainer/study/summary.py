"""Summary of a study: each cell's interquartile mean over its seeds, with its interval."""

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from reflexarc_sim_bridge.evaluation.scoring.statistics import (
    Estimate,
    estimate,
    interquartile_mean,
)
from reflexarc_trainer.study.definition import Cell, Study
from reflexarc_trainer.study.unit import Measure, Result


@dataclass(frozen=True)
class CellSummary:
    """A cell, and the results of its seeds together."""

    cell: Cell
    figures: tuple[float, ...]
    """The measured value of each seed that has one, in the order of the seeds."""
    estimate: Estimate | None
    """Interquartile mean of the figures, with its interval; None without figures."""
    share_of_blind: float | None
    """Interquartile mean of the contacts as a share of the blind agent's."""
    contacts: float | None
    """Interquartile mean of the contacts per 100 m."""
    blind: float | None
    """Contacts per 100 m of an agent that never steers, in the cell's worlds."""
    diverged: int
    """Number of seeds whose weights diverged; they have no figure."""
    missing: int
    """Number of seeds without a result."""
    unit_s: float
    """Mean wall-clock time of a unit."""


def summarise(study: Study, results: Mapping[str, Result]) -> list[CellSummary]:
    """The summaries of all cells, in their order.

    Args:
        study: the study.
        results: by unit hash.
    """
    return [_summary(study, cell, results) for cell in study.cells]


def missed_targets(study: Study, summaries: list[CellSummary]) -> list[str]:
    """For each bound of a target that does not hold: the cell, the value and the bound."""
    by_name = {summary.cell.name: summary for summary in summaries}
    return [
        f"{target.cell}: {words}"
        for target in study.targets
        for words in target.missed(by_name[target.cell].figures, len(study.seeds))
    ]


def _summary(study: Study, cell: Cell, results: Mapping[str, Result]) -> CellSummary:
    hashes = [study.unit(cell, seed).hash for seed in study.seeds]
    found = [results[name] for name in hashes if name in results]
    figures = _known(result.figure(study.measure) for result in found)
    times_s = [result.learning_s + result.evaluation_s for result in found]
    return CellSummary(
        cell=cell,
        figures=figures,
        estimate=estimate(figures) if figures else None,
        share_of_blind=_mean(result.share_of_blind for result in found),
        contacts=_mean(result.figure(Measure.CONTACTS) for result in found),
        blind=_mean(result.blind for result in found),
        diverged=sum(result.diverged for result in found),
        missing=len(hashes) - len(found),
        unit_s=math.fsum(times_s) / max(1, len(times_s)),
    )


def _known(figures: Iterable[float | None]) -> tuple[float, ...]:
    return tuple(figure for figure in figures if figure is not None)


def _mean(figures: Iterable[float | None]) -> float | None:
    known = _known(figures)
    return interquartile_mean(known) if known else None
