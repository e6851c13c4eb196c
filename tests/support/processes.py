"""Real processes of the real command, which never outlive their test."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.errors import LogError

PATIENCE_S = 240.0
"""Enough to compile the world on a busy machine; nothing waits for it to pass."""

Process = subprocess.Popen[str]


@contextmanager
def started(*words: object, cwd: Path | None = None, own_group: bool = False) -> Iterator[Process]:
    """`reflexarc WORDS` in the background; in a process group of its own, if asked to."""
    process = subprocess.Popen(
        [sys.executable, "-m", "reflexarc", *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=cwd,
        process_group=0 if own_group else None,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def finished(process: Process, number: signal.Signals | None = None) -> dict[str, Any]:
    """End a process, by a signal or by itself; what it printed with --json."""
    if number is not None:
        process.send_signal(number)
    said, complaint = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0, complaint
    result: dict[str, Any] = json.loads(said.splitlines()[-1])
    return result


def said_line(process: Process, words: str) -> str:
    """Wait until a process says a line with these words on standard error."""
    assert process.stderr is not None
    for line in process.stderr:
        if words in line:
            return line
    raise AssertionError(f"ended without saying {words!r}")


def reflexarc(*words: object, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """`reflexarc WORDS` to its end."""
    return subprocess.run(
        [sys.executable, "-m", "reflexarc", *map(str, words)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        cwd=cwd,
        check=False,
    )


def wait_for_records(log: Path, topic: str, count: int, patience_s: float = PATIENCE_S) -> None:
    """Wait until a recording that goes on holds so many messages of a topic on the disk."""
    wait_until(
        lambda: records_of(log, topic) >= count,
        f"{count} messages of {topic} in {log.name}.partial",
        patience_s,
    )


def records_of(log: Path, topic: str) -> int:
    """How many messages of a topic a recording that goes on holds on the disk."""
    partial = log.with_name(log.name + ".partial")
    try:
        records = read_log(partial, allow_truncated=True).records(f"/robot0/{topic}")
        return sum(1 for _ in records)
    except LogError:
        return 0  # not begun yet


def wait_until(holds: Any, what: str, patience_s: float = PATIENCE_S) -> None:
    """Poll until something holds."""
    end_s = time.monotonic() + patience_s
    while not holds():
        assert time.monotonic() < end_s, f"not within {patience_s:g} s: {what}"
        time.sleep(0.1)
