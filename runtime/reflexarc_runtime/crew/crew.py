"""A crew: worker processes that do tasks, replaced when they die.

A task whose worker died is given to a second worker; if that one dies too, the task has failed.
"""

import select
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence

from reflexarc_runtime.crew.worker_process import Done, Failure, Task, WorkerDied, WorkerProcess
from reflexarc_runtime.errors import UsageError

TRIES = 2
"""Workers that may die doing a task, before it has failed."""
MOST_JOBS = 256
MOST_STILLBORN = 3
"""Processes in a row that die before they are ready, after which no more are started."""

_LOOK_S = 0.1
"""Longest time between two calls of `should_stop`."""


class Crew:
    """Worker processes, and a queue of tasks for them; a context manager that ends the processes.

    Args:
        module: what the processes run: a module that calls `worker.serve`.
        tasks: to be done, in this order.
        jobs: number of processes, 1 or more.
        first_alone: whether the first task is done before the others are begun, as all workers
            would compile the same code at once.
    """

    def __init__(
        self, module: str, tasks: Sequence[Task], jobs: int, *, first_alone: bool = False
    ) -> None:
        self._module = module
        self._pending, self._tries = deque(tasks), Counter[str]()
        self._jobs = 1 if first_alone else jobs
        self._wanted_jobs = jobs
        self._workers: list[WorkerProcess] = []
        self._stillborn = 0

    def __enter__(self) -> "Crew":
        return self

    def __exit__(self, *_: object) -> None:
        for worker in self._workers:
            worker.end()
        self._workers.clear()

    def outcomes(self, should_stop: Callable[[], bool]) -> Iterator[Done | Failure]:
        """Do the tasks; yields the outcome of each as soon as it is known.

        Args:
            should_stop: called often; True ends the work, and tasks in progress have no outcome.

        Raises:
            UsageError: several processes died before they were ready.
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
        return len(self._pending) + sum(worker.task is not None for worker in self._workers)

    def _hire(self) -> None:
        """Start workers, up to one per task that is not done, and give tasks to the idle ones."""
        while len(self._workers) < min(self._jobs, self._undone):
            self._workers.append(WorkerProcess(self._module))
        for worker in self._workers:
            if worker.is_idle and self._pending:
                worker.give(self._pending.popleft())

    def _hear(self, worker: WorkerProcess) -> Done | Failure | None:
        """The outcome that a worker has reported, or None if it has reported that it is ready."""
        try:
            outcome = worker.hear()
        except WorkerDied as death:
            self._workers.remove(worker)
            worker.end()
            return self._bury(worker, str(death))
        self._stillborn = 0
        return outcome

    def _bury(self, worker: WorkerProcess, reason: str) -> Failure | None:
        """Queue the task of a dead worker once more, or return its failure after the last try."""
        task = worker.task
        if task is None:
            self._stillborn += 1
            if self._stillborn == MOST_STILLBORN:
                raise UsageError(f"its processes cannot begin; the last ended with {reason}")
            return None
        self._tries[task.key] += 1
        if self._tries[task.key] < TRIES:
            self._pending.appendleft(task)
            return None
        return Failure(task, f"{TRIES} processes died doing it; the last ended with {reason}")
