"""A study from its file to its page, in a folder of its own.

study.toml       the study as it was run
results.jsonl    one line a unit: see `results.py`
study.md         its page
study.png        its picture

Whatever there is already is not done again: a study that was broken off goes on, and one whose
grid has grown does what is new. Results of units that are no longer asked for, or that other code
gave, stay in the file and are not used.
"""

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from reflexarc_runtime.files import write_atomically
from reflexarc_trainer.study.crew import Crew
from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.figure import draw_study
from reflexarc_trainer.study.page import write_page
from reflexarc_trainer.study.results import ResultsFile, matching, read_results
from reflexarc_trainer.study.summary import CellSummary, missed_targets, summarise
from reflexarc_trainer.study.unit import Measure, Result, Unit, code_key
from reflexarc_trainer.study.worker_process import Failure

STUDY, RESULTS, PAGE, PICTURE = "study.toml", "results.jsonl", "study.md", "study.png"

_LEARNED_PER_S, _DRIVEN_PER_S = 5e5, 7e5
"""Steps a second of one processor, learning and measuring, presets of 2^19 steps on a shared
virtual core: for an estimate before anything has run."""


@dataclass(frozen=True)
class StudyProgress:
    """Where a study stands."""

    done: int
    units: int
    last: Result | None
    """What came last."""


@dataclass(frozen=True)
class StudyResult:
    """What a study gave."""

    out: Path
    summaries: tuple[CellSummary, ...]
    done: int
    """Units with a result."""
    units: int
    before: int
    """Results that were there already."""
    unused: int
    """Results of these units that other code gave."""
    failures: tuple[str, ...]
    """In words, which runs have no result and why."""
    interrupted: bool
    missed: tuple[str, ...]
    """Targets that are missed, in words; of a whole study only."""

    @property
    def page(self) -> Path:
        """Its page."""
        return self.out / PAGE


@dataclass(frozen=True)
class Plan:
    """What of a study is there and what is to do."""

    units: tuple[Unit, ...]
    there: dict[str, Result] = field(repr=False)
    """By unit hash."""
    unused: int
    """Results of these units that other code gave."""

    @property
    def pending(self) -> list[Unit]:
        """Units without a result."""
        return [unit for unit in self.units if unit.hash not in self.there]

    def estimate_s(self, jobs: int) -> float:
        """How long the rest may take on so many processors, compilation left out."""
        return math.fsum(_estimate_s(unit) for unit in self.pending) / jobs


def plan(study: Study, out: Path, any_code: bool = False) -> Plan:
    """What is to do.

    Args:
        study: the study.
        out: its folder, which need not exist.
        any_code: take results that other code gave, too.

    Raises:
        OSError: results are there and cannot be read.
    """
    units, results = tuple(study.units()), read_results(out / RESULTS)
    there = matching(results, units, "" if any_code else code_key())
    return Plan(units, there, len(matching(results, units, "")) - len(there))


def run_study(
    study: Study,
    out: Path,
    jobs: int,
    *,
    any_code: bool = False,
    progress: Callable[[StudyProgress], None] = lambda _: None,
    should_stop: Callable[[], bool] = lambda: False,
) -> StudyResult:
    """Do what is to do, and write the page of what there is.

    Args:
        study: the study.
        out: its folder, made if need be.
        jobs: how many processes.
        any_code: take results that other code gave, too.
        progress: told where the study stands, at the start and after each unit.
        should_stop: asked often; True ends the study before its end.

    Raises:
        UsageError: another process is at it in this folder, or no process can begin.
        OSError: the folder cannot be written.
    """
    failures: list[str] = []
    with ResultsFile(out / RESULTS) as file:
        write_atomically(out / STUDY, study.text.encode())
        todo = plan(study, out, any_code)
        there, before = dict(todo.there), len(todo.there)
        progress(StudyProgress(before, len(todo.units), None))
        with Crew(todo.pending, jobs) as crew:
            for outcome in crew.outcomes(should_stop):
                if isinstance(outcome, Failure):
                    failures.append(_failure_words(study, outcome))
                    continue
                file.append(outcome)
                there[outcome.unit] = outcome
                progress(StudyProgress(len(there), len(todo.units), outcome))
        summaries = summarise(study, there)
        _write(study, out, summaries)
    is_whole = len(there) + len(failures) == len(todo.units)
    return StudyResult(
        out=out,
        summaries=tuple(summaries),
        done=len(there),
        units=len(todo.units),
        before=before,
        unused=todo.unused,
        failures=tuple(failures),
        interrupted=not is_whole,
        missed=tuple(missed_targets(study, summaries)) if is_whole else (),
    )


def _write(study: Study, out: Path, summaries: Sequence[CellSummary]) -> None:
    write_atomically(out / PICTURE, draw_study(study, summaries))
    write_atomically(out / PAGE, write_page(study, summaries, PICTURE).encode())


def _failure_words(study: Study, failure: Failure) -> str:
    for cell, seed in itertools.product(study.cells, study.seeds):
        if study.unit(cell, seed).hash == failure.unit.hash:
            return f"{cell.name}, seed {seed}: {failure.reason}"
    return failure.reason


def _estimate_s(unit: Unit) -> float:
    scale = unit.evaluation
    drives = 2 if unit.measure is Measure.EDGE_INDEX else 1
    driven = drives * scale.agents * (scale.steps + scale.discard)
    return unit.config.steps / _LEARNED_PER_S + driven / _DRIVEN_PER_S
