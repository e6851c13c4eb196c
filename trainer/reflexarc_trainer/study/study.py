"""A study from its definition to its page, in a folder of its own.

study.toml       the definition as it was run
results.jsonl    one line per result: see `results.py`
study.md         its page
study.png        its figure

Units that have a result are not done again: an interrupted study continues, and one whose grid has
grown does the new units. Results of units that the study no longer has, or of other versions of the
code, stay in the file and are not used.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from reflexarc_runtime.crew.crew import Crew
from reflexarc_runtime.crew.worker_process import Failure, Task
from reflexarc_runtime.files import write_atomically
from reflexarc_sim_bridge.native.cache import has_compiled
from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.figure import draw_study
from reflexarc_trainer.study.page import write_page
from reflexarc_trainer.study.results import ResultsFile, matching, read_results
from reflexarc_trainer.study.summary import CellSummary, missed_targets, summarise
from reflexarc_trainer.study.unit import Measure, Result, Unit, code_key

STUDY, RESULTS, PAGE, PICTURE = "study.toml", "results.jsonl", "study.md", "study.png"

_WORKER = "reflexarc_trainer.study.worker"
_LEARNED_PER_S, _DRIVEN_PER_S = 5e5, 7e5
"""Steps per second of one processor, learning and measuring, for the estimate of a study's duration
(presets of 2^19 steps, on a shared virtual core)."""


@dataclass(frozen=True)
class StudyProgress:
    """How many units of a study are done."""

    done: int
    units: int
    last: Result | None
    """The result that came last; None at the start."""


@dataclass(frozen=True)
class StudyResult:
    """The outcome of a study."""

    out: Path
    summaries: tuple[CellSummary, ...]
    done: int
    """Units with a result."""
    units: int
    before: int
    """Results that existed before."""
    unused: int
    """Results of its units by other versions of the code, which are not used."""
    failures: tuple[str, ...]
    """For each unit that failed: its cell, its seed and the reason."""
    interrupted: bool
    """Whether units are left to do."""
    missed: tuple[str, ...]
    """Targets that are missed, in words; none while units are left to do."""

    @property
    def page(self) -> Path:
        """Path of its page."""
        return self.out / PAGE


@dataclass(frozen=True)
class Plan:
    """Which units of a study have a result, and which are to be done."""

    units: tuple[Unit, ...]
    there: dict[str, Result] = field(repr=False)
    """Existing results, by unit hash."""
    unused: int
    """Results of its units by other versions of the code, which are not used."""

    @property
    def pending(self) -> list[Unit]:
        """Units without a result."""
        return [unit for unit in self.units if unit.hash not in self.there]

    def estimate_s(self, jobs: int) -> float:
        """Estimated duration of the pending units on `jobs` processors, without compilation."""
        return math.fsum(_estimate_s(unit) for unit in self.pending) / jobs


def plan(study: Study, out: Path, any_code: bool = False) -> Plan:
    """Compare a study with the results in its folder.

    Args:
        study: the study.
        out: its folder, which need not exist.
        any_code: whether to use results by other versions of the code too.

    Raises:
        OSError: the results file exists and cannot be read.
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
    """Do the pending units, and write the page of all results.

    Args:
        study: the study.
        out: its folder, made if need be.
        jobs: number of worker processes.
        any_code: whether to use results by other versions of the code too.
        progress: called at the start and after each unit.
        should_stop: called often; True ends the study early.

    Raises:
        UsageError: another process runs a study in this folder, or no worker can start.
        OSError: the folder cannot be written.
    """
    with ResultsFile(out / RESULTS) as file:
        write_atomically(out / STUDY, study.text.encode())
        todo = plan(study, out, any_code)
        there, failures = dict(todo.there), list[str]()
        progress(StudyProgress(len(there), len(todo.units), None))
        tasks = [Task(unit.hash, unit.to_plain()) for unit in todo.pending]
        with Crew(_WORKER, tasks, jobs, first_alone=not has_compiled()) as crew:
            for outcome in crew.outcomes(should_stop):
                if isinstance(outcome, Failure):
                    failures.append(_failure_words(study, outcome))
                    continue
                result = Result.from_plain(outcome.answer)
                file.append(result)
                there[result.unit] = result
                progress(StudyProgress(len(there), len(todo.units), result))
        summaries = summarise(study, there)
        _write(study, out, summaries)
    return _result(study, out, todo, there, failures, summaries)


def _result(
    study: Study,
    out: Path,
    todo: Plan,
    there: Mapping[str, Result],
    failures: Sequence[str],
    summaries: list[CellSummary],
) -> StudyResult:
    """The outcome of a study that had a plan, and now has these results and failures."""
    is_whole = len(there) + len(failures) == len(todo.units)
    return StudyResult(
        out=out,
        summaries=tuple(summaries),
        done=len(there),
        units=len(todo.units),
        before=len(todo.there),
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
        if study.unit(cell, seed).hash == failure.task.key:
            return f"{cell.name}, seed {seed}: {failure.reason}"
    return failure.reason


def _estimate_s(unit: Unit) -> float:
    scale = unit.evaluation
    drives = 2 if unit.measure is Measure.EDGE_INDEX else 1
    driven = drives * scale.agents * (scale.steps + scale.discard)
    return unit.config.steps / _LEARNED_PER_S + driven / _DRIVEN_PER_S
