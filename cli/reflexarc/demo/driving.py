"""A drive with two real processes: a body and a runtime, on a port of their own."""

import contextlib
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from reflexarc.demo.results import Driving
from reflexarc.output import progress_bar
from reflexarc_runtime.bus import LOOPBACK
from reflexarc_runtime.errors import BusError

PATIENCE_S = 60.0
"""For a process to start, or to end after its work is done."""

_POLL_S = 0.1


def drive(policy: Path, log: Path, *, seconds: float, rate_hz: float, seed: int) -> Driving:
    """Drive for a while and record it.

    Raises:
        BusError: a process failed; the message is its own.
    """
    port = str(free_port())
    body_words = ["sim", "--policy", str(policy), "--port", port, "--seed", str(seed), "--json"]
    ticks = str(round(seconds * rate_hz))
    runtime_words = ["run", str(policy), "--record", str(log), "--ticks", ticks]
    with _process(body_words) as body:
        _await_start(body)
        with _process([*runtime_words, "--port", port, "--json"]) as runtime:
            _watch(runtime, seconds)
            ran = _finish(runtime)
        body.send_signal(signal.SIGINT)
        journey = _finish(body)
    ran.pop("recording")
    return Driving(**ran, distance_m=journey["distance_m"], contacts=journey["contacts"])


def free_port() -> int:
    """A port of the loopback interface that nobody listens on."""
    with socket.socket() as listener:
        listener.bind((LOOPBACK, 0))
        port: int = listener.getsockname()[1]
        return port


@contextlib.contextmanager
def _process(words: Sequence[str]) -> Iterator["subprocess.Popen[str]"]:
    process = subprocess.Popen(
        [sys.executable, "-m", "reflexarc", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def _await_start(process: "subprocess.Popen[str]") -> None:
    """The first line that a body says is that it is there."""
    assert process.stderr is not None
    line = process.stderr.readline()
    if process.poll() is not None or not line:
        raise BusError(line.strip() or "the body ended before it began")


def _watch(process: "subprocess.Popen[str]", seconds: float) -> None:
    began_s = time.monotonic()
    with progress_bar("driving", 1) as progress:
        while process.poll() is None and time.monotonic() - began_s < seconds + PATIENCE_S:
            progress(round(min(time.monotonic() - began_s, seconds) * 10), round(seconds * 10))
            time.sleep(_POLL_S)


def _finish(process: "subprocess.Popen[str]") -> dict[str, Any]:
    try:
        said, complaint = process.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        raise BusError(f"a process of the drive did not end: {process.args!r}") from None
    if process.returncode != 0:
        lines = complaint.strip().splitlines()
        raise BusError(lines[-1] if lines else "a process of the drive failed")
    result: dict[str, Any] = json.loads(said)
    return result
