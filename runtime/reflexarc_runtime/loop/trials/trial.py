"""Tries a policy file in a process of its own before the loop loads it.

A policy may hang while it is loaded, or while its golden vectors are computed, in code that listens
to nobody; or take more memory than there is. A process can be ended: `trial_process` is that one.
It also measures how long a decision takes: one retina at a time, the golden ones in turn, the
median.
"""

import json
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, TYPE_CHECKING, Any, Protocol, Self

from reflexarc_runtime.errors import PolicyError

if TYPE_CHECKING:  # this module is to be loaded quickly: the policy's libraries load beside it
    from reflexarc_runtime.policy.policy import LoadedPolicy

LOADING_S = 5.0
"""How long a policy may take to be loaded, checked and measured."""
STARTING_S = 60.0
"""How long a new process may take until it has loaded its modules, on a slow or busy machine."""
MEMORY_BYTES = 320 << 20
"""Address space that a policy may take beyond that of the process without one; with `PER_BYTE`."""
PER_BYTE = 8
"""What each byte of the file may take beside: read, parsed, widened to float64, and copied."""

DECISIONS = 24
"""How many decisions are measured, at most."""
READY = "ready"
"""What the process says when it has loaded its own modules."""
STDIN = "-"
"""Third word for the process where the policy's bytes come on its standard input."""

_PROCESS = "reflexarc_runtime.loop.trials.trial_process"


@dataclass(frozen=True)
class Finding:
    """What a trial found out."""

    policy_hash: str
    decision_ns: int
    """Median time of a decision."""


class TrialProcess(Protocol):
    """The process of a trial, as far as whoever waits for it is concerned: see `subprocess`."""

    @property
    def stdout(self) -> IO[str] | None:
        """What it prints."""
        ...

    @property
    def returncode(self) -> int | None:
        """Its status, once its end was seen."""
        ...

    def kill(self) -> None:
        """End it."""
        ...

    def wait(self) -> int:
        """Wait for its end."""
        ...

    def communicate(self) -> tuple[str, Any]:
        """What it prints up to its end."""
        ...


def spawned(path: Path, backend: str, data: bytes | None = None) -> TrialProcess:
    """Begin a trial in a new process.

    Args:
        path: the policy file.
        backend: what shall compute it.
        data: what was read of the file; None: the process reads it.
    """
    words = [sys.executable, "-P", "-m", _PROCESS, str(path), backend]
    if data is None:
        return _begun(words, subprocess.DEVNULL)
    with tempfile.TemporaryFile() as given:  # a pipe would hold up whoever fills it
        given.write(data)
        given.seek(0)
        return _begun([*words, STDIN], given)


def _begun(words: list[str], stdin: "int | IO[bytes]") -> TrialProcess:
    return subprocess.Popen(
        words, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
    )


class Trial:
    """A trial that goes on in the background; a context manager, which ends its process.

    Args:
        path: the policy file.
        backend: what shall compute it.
        loading_s: how long that may take.
        begin: begins its process.
    """

    def __init__(
        self,
        path: Path,
        backend: str,
        loading_s: float = LOADING_S,
        begin: Callable[[Path, str], TrialProcess] = spawned,
    ) -> None:
        self._path = path
        self._loading_s = loading_s
        self._process = begin(path, backend)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()

    def finding(self) -> Finding:
        """Wait for the end.

        Raises:
            PolicyError: the policy is refused, hangs, or breaks the process.
        """
        assert self._process.stdout is not None
        with ended_after(STARTING_S, self._process.kill):
            self._process.stdout.readline()  # it is ready
        with ended_after(self._loading_s, self._process.kill) as is_late:
            said, _ = self._process.communicate()
        if is_late():
            raise PolicyError(
                f"{self._path}: expected a policy that loads and decides within "
                f"{self._loading_s:g} s, got none: it hangs, or is too large for this machine"
            )
        return self._read(said)

    def _read(self, said: str) -> Finding:
        try:
            answer = json.loads(said)
        except ValueError:
            raise PolicyError(
                f"{self._path}: the process that tried it broke (status "
                f"{self._process.returncode}): it is damaged, or wants more than "
                f"{MEMORY_BYTES >> 20} MiB"
            ) from None
        if "error" in answer:
            raise PolicyError(answer["error"])
        return Finding(**answer)


def check_fits(finding: Finding, policy: "LoadedPolicy", *, in_real_time: bool = True) -> None:
    """Check that it is the policy that was tried, and that it decides within its period.

    In lockstep a period may take as long as it likes.

    Raises:
        PolicyError: it is not, or does not.
    """
    if finding.policy_hash != policy.policy_hash:
        raise PolicyError("the policy file changed while it was loaded; start again")
    rate_hz = policy.contract.rate_hz
    if in_real_time and finding.decision_ns > 1e9 / rate_hz:
        raise PolicyError(
            f"expected a decision within {1e3 / rate_hz:g} ms, the period at {rate_hz:g} Hz; got "
            f"{finding.decision_ns / 1e6:.1f} ms (median of {DECISIONS} on this machine); use a "
            "smaller network, another --backend, or a lower rate"
        )


class ended_after:  # noqa: N801  # read as a phrase
    """A context that calls `end` if it lasts longer than a time; its value tells whether it did."""

    def __init__(self, seconds: float, end: Callable[[], None]) -> None:
        self._late = False
        self._end = end
        self._timer = threading.Timer(seconds, self._expire)
        self._timer.daemon = True

    def __enter__(self) -> Callable[[], bool]:
        self._timer.start()
        return lambda: self._late

    def __exit__(self, *_: object) -> None:
        self._timer.cancel()

    def _expire(self) -> None:
        self._late = True
        self._end()
