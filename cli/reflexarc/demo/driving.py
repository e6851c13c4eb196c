"""A drive with two real processes, a body and a runtime, on a port that no other process uses."""

import signal
import time
from pathlib import Path

from reflexarc.demo.processes import (
    PATIENCE_S,
    Process,
    await_first_words,
    finish,
    free_port,
    started,
)
from reflexarc.demo.results import OF_THE_RUN, DriveResult
from reflexarc.terminal.output import progress_bar

_POLL_S = 0.1


def drive(policy: Path, log: Path, *, seconds: float, rate_hz: float, seed: int) -> DriveResult:
    """Drive for a while and record it.

    Raises:
        BusError: a process failed; the message is its own.
    """
    port, ticks = free_port(), round(seconds * rate_hz)
    body_words = ("sim", "--policy", policy, "--port", port, "--seed", seed, "--json")
    runtime_words = ("run", policy, "--record", log, "--ticks", ticks, "--port", port, "--json")
    with started(*body_words) as body:
        await_first_words(body)
        with started(*runtime_words) as runtime:
            _watch(runtime, seconds)
            ran = finish(runtime)
        journey = finish(body, signal.SIGINT)
    told = {name: ran[name] for name in OF_THE_RUN}
    return DriveResult(**told, distance_m=journey["distance_m"], contacts=journey["contacts"])


def _watch(process: Process, seconds: float) -> None:
    began_s = time.monotonic()
    with progress_bar("driving", 1) as progress:
        while process.poll() is None and time.monotonic() - began_s < seconds + PATIENCE_S:
            progress(round(min(time.monotonic() - began_s, seconds) * 10), round(seconds * 10))
            time.sleep(_POLL_S)
