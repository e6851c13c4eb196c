"""What processes took of the processors, by thread, and how long they waited for one.

All of it is the kernel's own count: `stat` and `schedstat` of each thread, and `smaps_rollup`.
"""

import os
import threading
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

_TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
_LOOK_S = 0.05
MS = 1_000_000


def processor_s(pid: int) -> Counter[str]:
    """Processor time of a process by the names of its threads, s; the first one is `main`."""
    found: Counter[str] = Counter()
    for task in _tasks(pid):
        try:
            text = (task / "stat").read_text()
        except OSError:
            continue
        name = text[text.index("(") + 1 : text.rindex(")")]
        fields = text[text.rindex(")") + 2 :].split()
        name = "main" if task.name == str(pid) else name.rstrip("0123456789")
        found[name] += (int(fields[11]) + int(fields[12])) * _TICK_S
    return found


def memory_mb(pid: int) -> dict[str, float]:
    """Resident and proportional memory, MB: what is shared counts for each, or by its share.

    Empty for a process that has ended.
    """
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except OSError:
        return {}
    rows = {line.split(":")[0]: line.split() for line in text.splitlines()[1:]}
    return {name.lower(): int(rows[name][1]) / 1024 for name in ("Rss", "Pss")}


def _tasks(pid: int) -> list[Path]:
    try:
        return list(Path(f"/proc/{pid}/task").iterdir())
    except OSError:
        return []


def _waited_ns(pid: int) -> int:
    """How long the threads of a process were ready and were not run."""
    total = 0
    for task in _tasks(pid):
        try:
            total += int((task / "schedstat").read_text().split()[1])
        except (OSError, IndexError):
            continue
    return total


@dataclass(frozen=True)
class Look:
    """What was seen between two looks."""

    from_ns: int
    to_ns: int
    late_ns: int
    """How late the second look was itself."""
    waited_ns: dict[str, int]
    """By process: how long its threads were ready and were not run."""


class Waits:
    """Looks again and again how long processes wait for a processor, and how late it is itself.

    Args:
        pids: the processes, by name.
    """

    def __init__(self, pids: dict[str, int]) -> None:
        self._pids = pids
        self._looks: list[Look] = []
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._look, daemon=True)
        self._thread.start()

    def end(self) -> None:
        """Look no more."""
        self._ended.set()
        self._thread.join()

    def evidence_ns(self, name: str, from_ns: int, to_ns: int) -> int:
        """How long the machine let a process wait, or this one, around a stretch of time."""
        around = [one for one in self._looks if one.to_ns >= from_ns and one.from_ns <= to_ns]
        waited = sum(one.waited_ns.get(name, 0) for one in around)
        return max(waited, max((one.late_ns for one in around), default=0))

    def last_of(self, name: str, within_ns: int) -> int:
        """How long a process that has ended had to wait, at the end of its life."""
        lived = [one.to_ns for one in self._looks if one.waited_ns.get(name)]
        end_ns = lived[-1] if lived else 0
        return self.evidence_ns(name, end_ns - within_ns, end_ns)

    def _look(self) -> None:
        before = {name: _waited_ns(pid) for name, pid in self._pids.items()}
        before_ns = time.monotonic_ns()
        while not self._ended.wait(_LOOK_S):
            now = {name: _waited_ns(pid) for name, pid in self._pids.items()}
            now_ns = time.monotonic_ns()
            late_ns = max(0, now_ns - before_ns - round(1e9 * _LOOK_S))
            waited = {name: max(0, now[name] - before[name]) for name in now}
            self._looks.append(Look(before_ns, now_ns, late_ns, waited))
            before, before_ns = now, now_ns
