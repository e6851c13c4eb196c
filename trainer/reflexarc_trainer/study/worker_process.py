"""A worker process as seen by the process that starts it: it is given units and answers."""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass

from reflexarc_trainer.study.unit import Result, Unit

_COMMAND = (sys.executable, "-P", "-m", "reflexarc_trainer.study.worker")
_SETTINGS = {"OPENBLAS_NUM_THREADS": "1", "OMP_WAIT_POLICY": "passive"}
"""Environment of the worker: one thread for NumPy, and no spinning while it waits."""
_SHOWN = 200
"""Characters of a worker's last words that are shown."""


@dataclass(frozen=True)
class Failure:
    """A unit that could not be done, and why."""

    unit: Unit
    reason: str


class WorkerDied(Exception):  # noqa: N818  # it is what happened
    """The process ended by itself; the message has its status and its last line of output."""


class WorkerProcess:
    """A process that runs `worker.py`. It answers once when it is ready, then once per unit."""

    def __init__(self) -> None:
        self.unit: Unit | None = None
        """The unit that it is doing."""
        self.is_ready = False
        self._complaints = tempfile.TemporaryFile()  # noqa: SIM115  # `end` closes it
        self._process = subprocess.Popen(
            _COMMAND,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            text=True,
            env={**os.environ, **_SETTINGS},
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._units, self._answers = self._process.stdin, self._process.stdout

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    @property
    def is_idle(self) -> bool:
        """Whether it is ready and has no unit."""
        return self.is_ready and self.unit is None

    def fileno(self) -> int:
        """File descriptor that becomes readable when it has answered or died, for `select`."""
        return self._answers.fileno()

    def give(self, unit: Unit) -> None:
        """Give it a unit. If the process is dead, `hear` raises `WorkerDied`."""
        self.unit = unit
        with contextlib.suppress(BrokenPipeError):
            self._units.write(json.dumps(unit.to_plain()) + "\n")
            self._units.flush()

    def hear(self) -> Result | Failure | None:
        """Read its answer: the outcome of its unit, or None if it has become ready.

        Raises:
            WorkerDied: the process has ended.
        """
        line = self._answers.readline()
        if not line.endswith("\n"):
            raise WorkerDied(self._last_words())
        message, unit, self.unit = json.loads(line), self.unit, None
        if unit is None:
            self.is_ready = True
            return None
        if "error" in message:
            return Failure(unit, message["error"])
        return Result.from_plain(message["result"])

    def end(self) -> None:
        """Kill the process, and wait until it has ended."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(BrokenPipeError):  # the last unit may not have been written yet
            self._units.close()
        self._answers.close()
        self._complaints.close()

    def _last_words(self) -> str:
        """How it ended, and its last line on standard error."""
        status = self._process.wait()
        self._complaints.seek(0)
        said = self._complaints.read().decode(errors="replace").strip().splitlines()
        how = f"signal {-status}" if status < 0 else f"exit status {status}"
        return f"{how}: {said[-1][:_SHOWN]}" if said else how
