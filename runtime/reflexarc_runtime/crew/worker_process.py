"""A worker process as seen by the process that starts it: it is given tasks and answers."""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from typing import Any

_COMMAND = (sys.executable, "-P", "-m")
_SETTINGS = {"OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive", "PYTHONHASHSEED": "0"}
"""Environment of the worker: one thread for NumPy, no spinning while it waits, and sets in the
same order every time."""
_SHOWN = 200
"""Characters of a worker's last words that are shown."""


@dataclass(frozen=True)
class Task:
    """Something to be done, as plain values that can be written as JSON."""

    key: str
    """Tells it apart from others."""
    plain: dict[str, Any] = field(repr=False)


@dataclass(frozen=True)
class Done:
    """A task that was done, and what came of it, as plain values."""

    task: Task
    answer: dict[str, Any]


@dataclass(frozen=True)
class Failure:
    """A task that could not be done, and why."""

    task: Task
    reason: str


class WorkerDied(Exception):  # noqa: N818  # it is what happened
    """The process ended by itself; the message has its status and its last line of output."""


class WorkerProcess:
    """A process that runs `worker.serve`. It answers once when it is ready, then once per task.

    Args:
        module: the module that it runs.
    """

    def __init__(self, module: str) -> None:
        self.task: Task | None = None
        """The task that it is doing."""
        self.is_ready = False
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115  # `end` closes it
        self._process = subprocess.Popen(
            (*_COMMAND, module),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            text=True,
            env={**os.environ, **_SETTINGS},
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._tasks, self._answers = self._process.stdin, self._process.stdout

    @property
    def is_idle(self) -> bool:
        """Whether it is ready and has no task."""
        return self.is_ready and self.task is None

    def fileno(self) -> int:
        """File descriptor that becomes readable when it has answered or died, for `select`."""
        return self._answers.fileno()

    def give(self, task: Task) -> None:
        """Give it a task. If the process is dead, `hear` raises `WorkerDied`."""
        self.task = task
        with contextlib.suppress(BrokenPipeError):
            self._tasks.write(json.dumps(task.plain) + "\n")
            self._tasks.flush()

    def hear(self) -> Done | Failure | None:
        """Read its answer: the outcome of its task, or None if it has become ready.

        Raises:
            WorkerDied: the process has ended.
        """
        line = self._answers.readline()
        if not line.endswith("\n"):
            raise WorkerDied(self._last_words())
        message, task, self.task = json.loads(line), self.task, None
        if task is None:
            self.is_ready = True
            return None
        if "error" in message:
            return Failure(task, message["error"])
        return Done(task, message["result"])

    def end(self) -> None:
        """Kill the process, and wait until it has ended."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(BrokenPipeError):  # the last task may not have been written yet
            self._tasks.close()
        self._answers.close()
        self._complaints.close()

    def _last_words(self) -> str:
        """How it ended, and its last line on standard error."""
        status = self._process.wait()
        self._complaints.seek(0)
        said = self._complaints.read().decode(errors="replace").strip().splitlines()
        how = f"signal {-status}" if status < 0 else f"exit status {status}"
        return f"{how}: {said[-1][:_SHOWN]}" if said else how
