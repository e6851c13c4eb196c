"""Processes that do a study's units, replaced when they die.

A unit whose worker died is given to another one once more; a unit that took two workers with it has
failed. With nothing compiled yet the first unit is done alone, as all would compile the same.
"""

import select
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.native.cache import cache_folder
from reflexarc_trainer.study.unit import Result, Unit
from reflexarc_trainer.study.worker_process import Failure, WorkerDied, WorkerProcess

TRIES = 2
MOST_JOBS = 256
MOST_STILLBORN = 3
"""So many processes in a row that died before they were ready: none ever will be."""

_LOOK_S = 0.1
"""Between two looks at `should_stop`."""


class Crew:
    """Some processes and the units that wait for them; a context manager, which ends them.

    Args:
        units: what to do, in this order.
        jobs: how many processes, 1 or more.
    """

    def __init__(self, units: Sequence[Unit], jobs: int) -> None:
        self._pending, self._tries = deque(units), Counter[str]()
        self._jobs = jobs if _has_compiled() else 1
        self._wanted_jobs = jobs
        self._workers: list[WorkerProcess] = []
        self._stillborn = 0

    def __enter__(self) -> "Crew":
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            worker.end()
        self._workers.clear()

    @property
    def pids(self) -> list[int]:
        """Numbers of the processes."""
        return [worker.pid for worker in self._workers]

    def outcomes(self, should_stop: Callable[[], bool]) -> Iterator[Result | Failure]:
        """What became of each unit, as it comes.

        Args:
            should_stop: asked often; True leaves undone what has no result yet.

        Raises:
            UsageError: processes die before they can begin.
        """
        while self._undone and not should_stop():
            self._hire()
            ready, _, _ = select.select(self._workers, (), (), _LOOK_S)
            for worker in ready:
                outcome = self._hear(worker)
                if outcome is not None:
                    self._jobs = self._wanted_jobs  # compiled by now
                    yield outcome

    @property
    def _undone(self) -> int:
        return len(self._pending) + sum(worker.unit is not None for worker in self._workers)

    def _hire(self) -> None:
        """Have as many workers as there is work for, and give the idle ones some."""
        while len(self._workers) < min(self._jobs, self._undone):
            self._workers.append(WorkerProcess())
        for worker in self._workers:
            if worker.is_idle and self._pending:
                worker.give(self._pending.popleft())

    def _hear(self, worker: WorkerProcess) -> Result | Failure | None:
        try:
            outcome = worker.hear()
        except WorkerDied as death:
            self._workers.remove(worker)
            worker.end()
            return self._bury(worker, str(death))
        self._stillborn = 0
        return outcome

    def _bury(self, worker: WorkerProcess, reason: str) -> Failure | None:
        """What becomes of the unit of a dead worker: done again, if this was its first death."""
        unit = worker.unit
        if unit is None:
            self._stillborn += 1
            if self._stillborn == MOST_STILLBORN:
                raise UsageError(f"study: its processes cannot begin; the last ended with {reason}")
            return None
        self._tries[unit.hash] += 1
        if self._tries[unit.hash] < TRIES:
            self._pending.appendleft(unit)
            return None
        return Failure(unit, f"{TRIES} processes died doing it; the last ended with {reason}")


def _has_compiled() -> bool:
    return next(cache_folder().rglob("*.nbc"), None) is not None
