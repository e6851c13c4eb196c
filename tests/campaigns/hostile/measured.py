"""One command on one hostile file: how it ended, how long it took, how much memory it had."""

import json
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

MOST_S = 10.0
MOST_BYTES = 500 << 20
KILLED_AFTER_S = 60.0

Maker: TypeAlias = Callable[[Path], tuple[Path, list[list[str]]]]
"""Writes one file into an empty folder; returns it, and the commands to try on it.

A command is its words after `reflexarc`. The word `FILE` stands for the file, `OUT` for a path that
does not exist yet; both may be part of a word (`OUT.mcap`).
"""

# The kernel counts a child's memory from the fork on, so that a large parent would be counted as
# the command's; this small process in between is not large.
_LAUNCHER = """
import json, os, signal, sys, time
began_s, pid = time.monotonic(), os.fork()
if not pid:
    os.execv(sys.argv[2], sys.argv[2:])
signal.signal(signal.SIGALRM, lambda *_: os.kill(pid, signal.SIGKILL))
signal.alarm(int(float(sys.argv[1])))
_, status, used = os.wait4(pid, 0)
took_s, cpu_s = time.monotonic() - began_s, used.ru_utime + used.ru_stime
row = [os.waitstatus_to_exitcode(status), took_s, cpu_s, used.ru_maxrss * 1024]
os.write(3, json.dumps(row).encode())
"""


@dataclass(frozen=True)
class Measured:
    """How a command ended."""

    status: int
    """Negative: the signal that ended it."""
    took_s: float
    cpu_s: float
    """Of the processor: what it would take on a machine that does nothing else."""
    peak_bytes: int
    out: str
    complaint: str

    @property
    def faults(self) -> list[str]:
        """What should not be, in a word each."""
        lines = [line for line in self.complaint.splitlines() if line.strip()]
        wrong = {
            "a traceback": "Traceback" in self.out + self.complaint,
            f"status {self.status}": self.status not in (0, 1, 2),
            f"{len(lines)} lines": self.status == 2 and len(lines) != 1,
            "slow": self.took_s > MOST_S and self.cpu_s > MOST_S,
            "large": self.peak_bytes > MOST_BYTES,
        }
        return [word for word, is_so in wrong.items() if is_so]


def measured(words: Sequence[str], folder: Path) -> Measured:
    """Run `reflexarc WORDS` to its end in a folder, or for a minute."""
    figures, out, complaint = (folder / name for name in ("figures", "stdout", "stderr"))
    command = [sys.executable, "-m", "reflexarc", *words]
    shell = [sys.executable, "-I", "-S", "-c", _LAUNCHER, str(KILLED_AFTER_S), *command]
    with figures.open("wb") as sink, out.open("wb") as said, complaint.open("wb") as grumbled:
        subprocess.run(
            ["/bin/sh", "-c", f'exec "$@" 3>&{sink.fileno()}', "sh", *shell],
            stdin=subprocess.DEVNULL,
            stdout=said,
            stderr=grumbled,
            pass_fds=(sink.fileno(),),
            cwd=folder,
            check=True,
        )
    status, took_s, cpu_s, peak_bytes = json.loads(figures.read_text())
    texts = [path.read_text(errors="replace") for path in (out, complaint)]
    return Measured(status, took_s, cpu_s, peak_bytes, *texts)
