"""Something done for each of many logs, shared among processes; the answers in the logs' order."""

import os
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from reflexarc_runtime.crew.crew import MOST_JOBS, Crew
from reflexarc_runtime.crew.worker_process import Failure, Task
from reflexarc_runtime.errors import ReflexarcError, UsageError

Work = Callable[[dict[str, Any]], dict[str, Any]]
Progress = Callable[[int, int], None]


class LogFailedError(ReflexarcError):
    """The work could not be done for one log; the message says why."""


def job_count(jobs: int) -> int:
    """How many processes: 0 means one for each processor.

    Raises:
        UsageError: fewer than none, or too many.
    """
    if not 0 <= jobs <= MOST_JOBS:
        raise UsageError(f"--jobs: expected 1 to {MOST_JOBS}, got {jobs}")
    return jobs or len(os.sched_getaffinity(0))


def share_work(
    module: str,
    work: Work,
    tasks: Mapping[str, dict[str, Any]],
    jobs: int,
    progress: Progress = lambda done, of: None,
) -> dict[str, dict[str, Any] | LogFailedError]:
    """Do the work for each log; with one process, in this one.

    Args:
        module: what processes run to do the work.
        work: the same, for this process.
        tasks: what the work is given, by the log's name.
        jobs: processes.
        progress: called with the logs done and the logs in all.

    Returns:
        The answers by the log's name, in the order of `tasks`; or why there is none.
    """
    found: dict[str, dict[str, Any] | LogFailedError] = {}
    if min(jobs, len(tasks)) <= 1:
        for name, plain in tasks.items():
            found[name] = _done_here(work, plain)
            progress(len(found), len(tasks))
        return found
    shared = [Task(name, {"path": sys.path, **plain}) for name, plain in tasks.items()]
    with Crew(module, shared, jobs) as crew:
        for outcome in crew.outcomes(lambda: False):
            if isinstance(outcome, Failure):
                found[outcome.task.key] = LogFailedError(outcome.reason)
            else:
                found[outcome.task.key] = outcome.answer
            progress(len(found), len(tasks))
    return {name: found[name] for name in tasks}


def _done_here(work: Work, plain: dict[str, Any]) -> dict[str, Any] | LogFailedError:
    try:
        return work(plain)
    except ReflexarcError as error:
        return LogFailedError(str(error))


def sizes_first(paths: Mapping[str, Path]) -> Sequence[str]:
    """The names of logs, the largest first: so that no process is left with it at the end."""
    return sorted(paths, key=lambda name: (-_size(paths[name]), name))


def _size(path: Path) -> int:
    try:
        return path.stat().st_size
    except OSError:
        return 0  # why it cannot be read is said when it is
