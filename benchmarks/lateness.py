"""How late the loop's ticks begin at 1 kHz under SCHED_FIFO, in turns with `cyclictest`.

    python benchmarks/lateness.py [--rounds 5] [--seconds 5] [--cpu 1] [--priority 80] [--json]

Each round runs `cyclictest -p 80 -i 1000 -m` (Debian's rt-tests), `reflexarc run --realtime warn
--fifo 80` with guard and watchdog, and the same with a recorder, each with its loop on the same
processor, beside a body that sends retinas at 200 Hz. It needs the right to SCHED_FIFO. Nothing is
asserted.

The machine's evidence of the same minute stands beside the skipped slots: how long the loop's own
thread was ready and got no processor (the kernel's `schedstat`), what the hypervisor took (`steal`
in /proc/stat), how many threads of other programs had a real-time priority (they can take the
processor from a thread that holds the interpreter's lock), and how late cyclictest was at most.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from loop import body_beside, policy_at

from reflexarc.doctoring.cyclictest import parse_histogram
from reflexarc.doctoring.processors import stolen_ticks

LOOPS = {
    "the loop": ("--realtime", "warn"),
    "the loop, recording": ("--realtime", "warn", "--record"),
    "the same, --spin-us 100": ("--realtime", "warn", "--spin-us", "100", "--record"),
}
_OF_THE_KERNEL = 0x00200000
"""PF_KTHREAD among a thread's flags (include/linux/sched.h)."""
COLUMNS = ("p50", "p99", "p99.9", "max")


def main() -> None:
    """Measure in turns, and print the table."""
    flags = _flags()
    found: dict[str, list[dict[str, float]]] = {}
    for _ in range(flags.rounds):
        found.setdefault("cyclictest", []).append(_cyclictest(flags))
        for name, more in LOOPS.items():
            found.setdefault(name, []).append(_run(more, flags))
    if flags.json:
        print(json.dumps({"load": os.getloadavg()[0], "rounds": found}))
        return
    load = f"load average {os.getloadavg()[0]:.1f}"
    print(f"{load}; µs, medians over {flags.rounds} rounds, max of all; the rest each round\n")
    print("| 1 kHz | p50 | p99 | p99.9 | max | skipped | ready, not run, ms | steal, ms | others |")
    print("|---|---|---|---|---|---|---|---|---|")
    for name, rounds in found.items():
        print(_row(name, rounds))


def _row(name: str, rounds: list[dict[str, float]]) -> str:
    def each(column: str) -> str:
        return ", ".join(f"{row[column]:g}" for row in rounds) if column in rounds[0] else "–"

    times = [f"{statistics.median(r[c] for r in rounds):.0f}" for c in ("p50", "p99", "p99.9")]
    most = f"{max(row['max'] for row in rounds):.0f}"
    cells = [name, *times, most, each("skipped"), each("not run"), each("steal"), each("others")]
    return f"| {' | '.join(cells)} |"


def _flags() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--cpu", type=int, default=1)
    parser.add_argument("--priority", type=int, default=80)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _ticks(flags: argparse.Namespace) -> int:
    return round(flags.rate * flags.seconds)


def _cyclictest(flags: argparse.Namespace) -> dict[str, float]:
    words = ["cyclictest", "-q", "-m", "-t", "1", "-p", str(flags.priority), "-h", "100000"]
    words += ["-i", str(round(1e6 / flags.rate)), "-l", str(_ticks(flags)), "-a", str(flags.cpu)]
    before = stolen_ticks()
    said = subprocess.run(words, check=True, capture_output=True, text=True).stdout
    spread = parse_histogram(said)
    assert spread is not None, said
    late = (spread.p50_ns, spread.p99_ns, spread.p999_ns, spread.max_ns)
    figures = dict(zip(COLUMNS, [ns / 1e3 for ns in late], strict=False))
    return {**figures, "steal": _steal_since(before)}


def _run(more: tuple[str, ...], flags: argparse.Namespace) -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder, body_beside(200.0) as port:
        policy = policy_at(flags.rate, None, Path(folder))
        words = [sys.executable, "-m", "reflexarc", "run", str(policy), "--port", str(port)]
        words += ["--fifo", str(flags.priority), "--cpu", str(flags.cpu), "--json"]
        words += ["--ticks", str(_ticks(flags)), *more]
        words += [f"{folder}/log.mcap"] if more[-1] == "--record" else []
        before = stolen_ticks()
        with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as run:
            waited_ns, others = _seen_while(run)
            assert run.stdout is not None
            out = run.stdout.read()
        if run.returncode:
            raise SystemExit(f"{' '.join(words)}: status {run.returncode}")
    said = json.loads(out)
    late = said["phases"]["lateness"]
    times = [late[f"{name}_ns"] / 1e3 for name in ("p50", "p99", "p999", "max")]
    figures = dict(zip(COLUMNS, times, strict=False))
    account = {
        "skipped": said["skipped_slots"],
        "not run": round(waited_ns / 1e6, 1),
        "others": others,
    }
    return {**figures, **account, "steal": _steal_since(before)}


def _seen_while(run: "subprocess.Popen[str]") -> tuple[int, int]:
    """While the loop had its priority: how long it was ready without a processor, ns; others'
    threads of a real-time priority, at most.
    """
    first = last = None
    others, looks = 0, 0
    folder = Path(f"/proc/{run.pid}/task/{run.pid}")
    while run.poll() is None:
        with suppress(OSError, ValueError, IndexError):
            if re.search(r"^policy\s*:\s*1$", (folder / "sched").read_text(), re.MULTILINE):
                last = int((folder / "schedstat").read_text().split()[1])
                first = last if first is None else first
                looks += 1
                others = max(others, _urgent_threads(run.pid) if looks % 20 == 1 else 0)
        time.sleep(0.05)
    return 0 if first is None or last is None else last - first, others


def _urgent_threads(own: int) -> int:
    """Threads of other programs with a real-time priority: field 40 of their stat, proc(5)."""
    count = 0
    for folder in Path("/proc").glob("[0-9]*/task/[0-9]*"):
        with suppress(OSError, ValueError, IndexError):
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
            is_kernels = int(fields[6]) & _OF_THE_KERNEL
            count += int(fields[37]) > 0 and not is_kernels and folder.parts[2] != str(own)
    return count


def _steal_since(before: tuple[int, int] | None) -> float:
    """Milliseconds that the hypervisor took from all processors."""
    after = stolen_ticks()
    if before is None or after is None:
        return 0.0
    return 1e3 * (after[0] - before[0]) / os.sysconf("SC_CLK_TCK")


if __name__ == "__main__":
    main()
