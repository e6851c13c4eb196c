"""A worker as the process that started it sees it: give it a unit, hear what became of it."""

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
"""Before NumPy and numba load: one thread, which does not spin while it waits."""
_SHOWN = 200


@dataclass(frozen=True)
class Failure:
    """A unit without a result."""

    unit: Unit
    reason: str


class WorkerDied(Exception):  # noqa: N818  # it is what happened
    """The process ended; the message says what it said last."""


class WorkerProcess:
    """A process that runs `worker.py`. It answers once when it is ready, then once a unit."""

    def __init__(self) -> None:
        self.unit: Unit | None = None
        """What it is doing."""
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
        """Number of the process."""
        return self._process.pid

    @property
    def is_idle(self) -> bool:
        """Whether it waits for a unit."""
        return self.is_ready and self.unit is None

    def fileno(self) -> int:
        """What becomes readable when it has answered, or died."""
        return self._answers.fileno()

    def give(self, unit: Unit) -> None:
        """Let it do a unit. If it is dead, `hear` will say so."""
        self.unit = unit
        with contextlib.suppress(BrokenPipeError):
            self._units.write(json.dumps(unit.to_plain()) + "\n")
            self._units.flush()

    def hear(self) -> Result | Failure | None:
        """Its answer: what became of the unit, or None when it has become ready.

        Raises:
            WorkerDied: it has died.
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
        """End it, whatever it is doing, and wait until it is gone."""
        self._process.kill()
        self._process.wait()
        with contextlib.suppress(BrokenPipeError):  # what it was given last never reached it
            self._units.close()
        self._answers.close()
        self._complaints.close()

    def _last_words(self) -> str:
        """How it ended, and the last line that it left on standard error."""
        status = self._process.wait()
        self._complaints.seek(0)
        said = self._complaints.read().decode(errors="replace").strip().splitlines()
        how = f"signal {-status}" if status < 0 else f"exit status {status}"
        return f"{how}: {said[-1][:_SHOWN]}" if said else how
