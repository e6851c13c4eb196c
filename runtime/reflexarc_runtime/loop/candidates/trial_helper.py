"""A process that starts trials for a loop that is running.

A process that starts another one stands still until that one has begun, with the interpreter's lock
in its hand: on a busy machine longer than a loop may be late. So a helper, started before the first
tick, starts them; the loop's own process only reads and writes a pipe. It ends with the pipe.
"""

import json
import subprocess
import sys
from pathlib import Path
from types import TracebackType
from typing import Protocol, Self

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.trial import Finding, Trial

_PROCESS = "reflexarc_runtime.loop.candidates.trial_helper_process"


class Tries(Protocol):
    """Tries a policy file."""

    def finding(self, path: Path, backend: str) -> Finding:
        """What a trial found: see `Trial.finding`."""
        ...


class TrialHere:
    """Starts trials itself: for whoever has no loop to hold up."""

    def finding(self, path: Path, backend: str) -> Finding:
        """See `Tries.finding`."""
        with Trial(path, backend) as trial:
            return trial.finding()


class TrialHelper:
    """A helper. A context manager; leaving it ends the process."""

    def __enter__(self) -> Self:
        pipe, nowhere = subprocess.PIPE, subprocess.DEVNULL
        words = [sys.executable, "-P", "-m", _PROCESS]
        self._process = subprocess.Popen(
            words, stdin=pipe, stdout=pipe, stderr=nowhere, text=True, bufsize=1
        )
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        with self._process as process:
            process.wait()

    def finding(self, path: Path, backend: str) -> Finding:
        """See `Tries.finding`; from one thread at a time."""
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        try:
            process.stdin.write(json.dumps([str(path), backend]) + "\n")
            process.stdin.flush()
            answer = json.loads(process.stdout.readline())
        except (OSError, ValueError):
            raise PolicyError(
                "expected the process that tries policies, it has ended; start the runtime again"
            ) from None
        if "error" in answer:
            raise PolicyError(answer["error"])
        return Finding(**answer)
