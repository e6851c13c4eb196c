"""Tries how punctual a loop is on this machine, in processes of their own."""

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from reflexarc.doctoring.cyclictest import cyclictest
from reflexarc_runtime.messages.spread import Spread

_PROCESS = "reflexarc.doctoring.lateness_process"
_STARTING_S = 30.0


@dataclass(frozen=True)
class Punctuality:
    """How punctual a loop was under one scheduling."""

    scheduling: str
    lateness: Spread
    tick: Spread | None
    """From waking to the command; None without a policy."""
    record: Spread | None
    skipped: int = 0
    beside: Spread | None = None
    """What C got beside it."""
    beside_by: str = ""


@dataclass(frozen=True)
class NoPunctuality:
    """It could not be measured."""

    scheduling: str
    why: str


def try_lateness(
    rate_hz: float, seconds: float, fifo: int, policy: Path | None, backend: str = "numpy"
) -> Punctuality | NoPunctuality:
    """Measure the loop, and C beside it.

    Args:
        rate_hz: of the loop.
        seconds: how long.
        fifo: priority; 0: ordinary scheduling.
        policy: whose ticks it makes; None: it only wakes.
        backend: what computes it.
    """
    scheduling = f"SCHED_FIFO {fifo}" if fifo else "ordinary"
    own = _try("loop", rate_hz, seconds, fifo, policy, backend)
    if isinstance(own, str):
        return NoPunctuality(scheduling, own)
    beside, by = cyclictest(rate_hz, seconds, fifo), "cyclictest"
    if beside is None:
        in_c = _try("c", rate_hz, seconds, fifo, None)
        by = "clock_nanosleep, as cyclictest is not here, or refused (apt install rt-tests)"
        beside = None if isinstance(in_c, str) else _spread(in_c["lateness"])
    return Punctuality(
        scheduling,
        _spread(own["lateness"]),
        _spread(own["waking to command"]) if "waking to command" in own else None,
        _spread(own["record"]) if "record" in own else None,
        int(str(own.get("skipped", 0))),
        beside,
        by,
    )


def _try(
    role: str, rate_hz: float, seconds: float, fifo: int, policy: Path | None, backend: str = ""
) -> dict[str, object] | str:
    """What it printed, or why it did not."""
    words = [sys.executable, "-P", "-m", _PROCESS, role, str(rate_hz), str(seconds), str(fifo)]
    words += [] if policy is None else [str(policy), backend]
    try:
        done = subprocess.run(
            words,
            capture_output=True,
            text=True,
            timeout=4 * seconds + _STARTING_S,
            check=False,
        )
        found = json.loads(done.stdout)
        return found if isinstance(found, dict) else "it says nothing"
    except subprocess.TimeoutExpired:
        return "it hangs"
    except ValueError:
        last = done.stderr.strip().splitlines()[-1:] or [f"status {done.returncode}"]
        return last[0][:200]


def _spread(document: object) -> Spread:
    assert isinstance(document, dict)
    return Spread(**{**document, "octaves": tuple(document.get("octaves", ()))})
