"""Runs a suite: all contenders in all cells and settings, shared among processes.

Each unit that is done is kept in `rows.jsonl` of the run's folder at once. A run that goes on takes
the lines whose keys it would compute again, and no others: see `suite_unit.py`.
"""

import copy
import sys
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from tempfile import TemporaryDirectory

from reflexarc_runtime.crew.crew import Crew
from reflexarc_runtime.crew.lines_file import LinesFile, read_lines
from reflexarc_runtime.crew.worker_process import Failure, Task
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_sim_bridge.evaluation.driving.decision_times import DecisionTimes, decision_times
from reflexarc_sim_bridge.evaluation.protocol.agent_facts import agent_of
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.results import Agent, CellFacts, Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite
from reflexarc_sim_bridge.evaluation.running.doing import PlainSums, drive_alike
from reflexarc_sim_bridge.evaluation.running.plan import (
    Job,
    Starter,
    filled,
    plan_suite,
    starters_of,
)
from reflexarc_sim_bridge.native.cache import has_compiled

ROWS = "rows.jsonl"
BOTH = (Setting.ROBOT, Setting.FIELD)
_WORKER = "reflexarc_sim_bridge.evaluation.running.suite_worker"


@dataclass(frozen=True)
class RunOptions:
    """How a suite is run; none of it shows in the numbers."""

    jobs: int = 1
    """Processes."""
    folder: Path | None = None
    """Where units that are done are kept; None: nowhere."""
    resume: bool = False
    """Whether units of an earlier run in that folder are taken."""
    progress: Callable[[float, float], None] = lambda done, total: None
    """Called at the start and after each unit, with what is done and what there is in all."""


@dataclass(frozen=True)
class SuiteRun:
    """What came of a suite."""

    results: Results
    times: dict[str, DecisionTimes] = field(default_factory=dict)
    """How long the decisions of each contender take. Not a part of the results: it differs from run
    to run."""


def run_suite(
    suite: Suite,
    entrants: Sequence[Entrant | Contender],
    settings: Sequence[Setting] = BOTH,
    options: RunOptions | None = None,
) -> SuiteRun:
    """Measure contenders in all cells of a suite.

    Entrants are made anew in worker processes; contenders that are objects drive in this one.

    Raises:
        ReflexarcError: a contender cannot be made, or cannot drive, or its code failed: with its
            name and cell.
        OSError: the folder cannot be written.
    """
    options = options or RunOptions()
    starters = starters_of(entrants)
    jobs, limits = plan_suite(suite, starters, settings)
    with ExitStack() as stack:
        folder = options.folder or Path(stack.enter_context(TemporaryDirectory()))
        file = stack.enter_context(LinesFile(folder / ROWS, "evaluation"))
        there = _kept(folder, file, options.resume)
        _do_all([*jobs, *limits], there, file, options)
    there |= {job.key: drive_here(job, suite) for job in jobs if job.unit is None}
    return SuiteRun(results_of(suite, starters, jobs, limits, there), _times(starters))


def results_of(
    suite: Suite,
    starters: Sequence[Starter],
    jobs: Sequence[Job],
    limits: Sequence[Job],
    there: Mapping[str, PlainSums],
) -> Results:
    """The results of a plan, from the sums of its jobs by their keys."""
    return Results(
        suite=suite.title,
        version=_version(),
        agents=[_agent(starter) for starter in starters],
        rows=[filled(job, there[job.key]) for job in jobs],
        limits=[filled(job, there[job.key]) for job in limits if there[job.key]],
        cells=_cells(suite),
    )


def _kept(folder: Path, file: LinesFile, resume: bool) -> dict[str, PlainSums]:
    """Units of an earlier run, by their keys; lines of other versions are left alone."""
    if not resume:
        file.empty()
        return {}
    there = {}
    for line in read_lines(folder / ROWS):
        if isinstance(line.get("key"), str) and isinstance(line.get("sums"), dict):
            there[line["key"]] = line["sums"]
    return there


def _do_all(
    jobs: Sequence[Job], there: dict[str, PlainSums], file: LinesFile, options: RunOptions
) -> None:
    """Do the units that are not there yet, the long ones first."""
    wanted = {job.key: job for job in jobs if job.unit is not None}
    pending = [job for key, job in wanted.items() if key not in there]
    total = sum(job.weight for job in wanted.values())
    done = total - sum(job.weight for job in pending)
    options.progress(done, total)
    tasks = [_task(job) for job in sorted(pending, key=lambda job: -job.weight)]
    with Crew(_WORKER, tasks, options.jobs, first_alone=not has_compiled()) as crew:
        for outcome in crew.outcomes(lambda: False):
            job = wanted[outcome.task.key]
            if isinstance(outcome, Failure):
                raise UsageError(f"{job.where}: {outcome.reason}")
            file.append_line({"key": job.key, "sums": outcome.answer})
            there[job.key] = outcome.answer
            done += job.weight
            options.progress(done, total)


def _task(job: Job) -> Task:
    assert job.unit is not None
    return Task(job.key, {"unit": job.unit.to_plain(), "path": sys.path})


def drive_here(job: Job, suite: Suite) -> PlainSums:
    """Drive a copy of a contender that is an object of this process.

    Raises:
        ReflexarcError: it cannot drive; with its name and cell.
    """
    assert job.starter is not None
    contender = job.starter.contender

    def make() -> Contender:
        try:
            return copy.deepcopy(contender)
        except Exception:  # what cannot be copied is what it has become
            return contender

    try:
        return drive_alike(make, job.cell, suite, job.row.setting)
    except ReflexarcError as error:
        raise UsageError(f"{job.where}: {error}") from error


def _agent(starter: Starter) -> Agent:
    source = starter.entrant.source if starter.entrant else "object"
    return agent_of(starter.contender, source, starter.content)


def _cells(suite: Suite) -> list[CellFacts]:
    return [
        CellFacts(family.name, cell.tier, cell.world, cell.clutter, cell.counts)
        for family, cell in suite.cells
    ]


def _times(starters: Sequence[Starter]) -> dict[str, DecisionTimes]:
    """Of all who decide by what they see."""
    contenders = [each.contender for each in starters]
    return {
        each.name: decision_times(each) for each in contenders if hasattr(each.policy, "decide")
    }


def _version() -> str:
    try:
        return version("reflexarc")
    except PackageNotFoundError:
        return "source"
