"""Runs `reflexarc` commands as processes of their own, which never outlive the demo."""

import contextlib
import json
import socket
import subprocess
import sys
from collections.abc import Iterator
from typing import Any, TypeAlias

from reflexarc_runtime.bus_config import LOOPBACK
from reflexarc_runtime.errors import BusError

PATIENCE_S = 60.0
"""For a process to start, or to end after its work is done."""

Process: TypeAlias = "subprocess.Popen[str]"


def free_port() -> int:
    """A free port of the loopback interface."""
    with socket.socket() as listener:
        listener.bind((LOOPBACK, 0))
        port: int = listener.getsockname()[1]
        return port


@contextlib.contextmanager
def started(*words: object) -> Iterator[Process]:
    """`reflexarc WORDS` in the background."""
    process = subprocess.Popen(
        [sys.executable, "-m", "reflexarc", *map(str, words)],
        stdin=subprocess.DEVNULL,
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


def await_first_words(process: Process) -> None:
    """Wait for the first line of a process, which says that it is ready.

    Raises:
        BusError: it ended before; the message is its own.
    """
    assert process.stderr is not None
    line = process.stderr.readline()
    if process.poll() is not None or not line:
        raise BusError(line.strip() or "a process of the demo ended before it began")


def finish(process: Process, number: int | None = None) -> dict[str, Any]:
    """Wait for the end of a process, after a signal if one is given; return what --json printed.

    Raises:
        BusError: it failed, or did not end in time.
    """
    if number is not None:
        process.send_signal(number)
    try:
        said, complaint = process.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        raise BusError(f"a process of the demo did not end: {process.args!r}") from None
    if process.returncode != 0:
        lines = complaint.strip().splitlines()
        raise BusError(lines[-1] if lines else "a process of the demo failed")
    result: dict[str, Any] = json.loads(said)
    return result
