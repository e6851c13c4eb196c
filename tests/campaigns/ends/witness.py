"""A witness of what the machine oversleeps: `python -m campaigns.ends.witness FILE`, until SIGTERM.

One thread a core, kept there, sleeps 2 ms at a time, and notes when it was woken later than that.
A robot that is told too late may blame the machine only for time that a witness has missed, too.
"""

import os
import signal
import sys
import threading
import time
from collections.abc import Sequence
from pathlib import Path

STEP_NS = 2_000_000
NOTED_NS = 1_000_000
"""A shorter oversleep is usual."""

Overslept = tuple[int, int]
"""(when a sleeper should have been woken, when it was), ns on the wall clock."""


def overslept_ns(seen: Sequence[Overslept], since_ns: int, until_ns: int) -> int:
    """For how long, between two moments, at least one core woke somebody too late."""
    total_ns, reached_ns = 0, since_ns
    for due_ns, woken_ns in sorted(seen):
        begin_ns, end_ns = max(due_ns, reached_ns), min(woken_ns, until_ns)
        if end_ns > begin_ns:
            total_ns += end_ns - begin_ns
            reached_ns = end_ns
    return total_ns


def read(path: Path) -> list[Overslept]:
    """What a witness wrote, in the order of time."""
    rows = (line.split() for line in path.read_text().splitlines())
    return sorted((int(due), int(woken)) for due, woken in rows)


def _watch(core: int, seen: list[Overslept], ended: threading.Event) -> None:
    os.sched_setaffinity(0, {core})  # of this thread alone
    while not ended.is_set():
        due_ns = time.time_ns() + STEP_NS
        time.sleep(STEP_NS * 1e-9)
        now_ns = time.time_ns()
        if now_ns - due_ns > NOTED_NS:
            seen.append((due_ns, now_ns))


def main(path: Path) -> None:
    """Watch every core until SIGTERM, then write what was seen."""
    ended, seen = threading.Event(), list[Overslept]()
    signal.signal(signal.SIGTERM, lambda number, frame: ended.set())
    threads = [
        threading.Thread(target=_watch, args=(core, seen, ended))
        for core in os.sched_getaffinity(0)
    ]
    for thread in threads:
        thread.start()
    while not ended.wait(0.5):
        pass
    for thread in threads:
        thread.join()
    path.write_text("".join(f"{due} {woken}\n" for due, woken in seen))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
