"""Checks many logs, several at a time; the report is the same however many."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from reflexarc_logs.checking.check import check
from reflexarc_logs.checking.check_report import CheckReport, LogCheck
from reflexarc_runtime.crew.crew import Crew
from reflexarc_runtime.crew.worker_process import Failure, Task

_WORKER = "reflexarc_logs.checking.check_worker"


def check_logs(
    paths: Sequence[Path], jobs: int, progress: Callable[[int, int], None] = lambda *_: None
) -> CheckReport:
    """Check logs.

    Args:
        paths: the files.
        jobs: processes; 1: this one.
        progress: called with the logs done and the logs in all.
    """
    found: list[LogCheck] = []
    for one in map(check, paths) if min(jobs, len(paths)) < 2 else _by_crew(paths, jobs):
        found.append(one)
        progress(len(found), len(paths))
    return CheckReport.of(found)


def _by_crew(paths: Sequence[Path], jobs: int) -> Iterator[LogCheck]:
    tasks = [Task(str(number), {"path": str(path)}) for number, path in enumerate(paths)]
    with Crew(_WORKER, tasks, jobs) as crew:
        for outcome in crew.outcomes(lambda: False):
            if isinstance(outcome, Failure):
                yield LogCheck(outcome.task.plain["path"], refusal=outcome.reason)
            else:
                yield LogCheck.from_plain(outcome.answer)
