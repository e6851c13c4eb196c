"""A loop of 1 kHz for ten minutes: does its memory grow, and which slots does it skip?

    chrt -f 50 python benchmarks/soak.py [--minutes 10] [--fifo 50] [--json]

`reflexarc run` with recorder and shadow, a body that sends retinas at 200 Hz, and a process that
loads one core with ordinary priority. Every ten seconds: what the kernel says of the loop's memory
(`VmRSS`). Beside it, a process that only sleeps to the same absolute deadlines, by the same
scheduling, says which deadlines the machine itself missed: a skipped slot has its evidence if that
one missed a deadline in the same minute, or even in the same second. Nothing is asserted.
"""

import argparse
import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime import messages_pb2 as pb
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT
from support.ros2_robot import free_port

RATE_HZ = 1000
PERIOD_NS = round(1e9 / RATE_HZ)
SECOND_NS = 1_000_000_000
LOAD = "while True: pass"
SLEEPER = """
import sys, time
from reflexarc_runtime.loop import realtime
period_ns, end_ns = int(sys.argv[1]), time.monotonic_ns() + int(float(sys.argv[2]) * 1e9)
realtime.prepare(int(sys.argv[3]))
due_ns = time.monotonic_ns()
while due_ns < end_ns:
    due_ns += period_ns
    wait_ns = due_ns - time.monotonic_ns()
    if wait_ns > 0:
        time.sleep(wait_ns * 1e-9)
    now_ns = time.monotonic_ns()
    if now_ns - due_ns >= period_ns:
        print(due_ns, now_ns - due_ns, flush=True)
        due_ns += (now_ns - due_ns) // period_ns * period_ns
"""
"""Prints each deadline that it missed by a period, and by how much."""


def main() -> None:
    """Run, and print what was seen."""
    flags = _flags()
    with tempfile.TemporaryDirectory() as folder:
        found = _soak(flags, Path(folder))
    if flags.json:
        print(json.dumps(found))
        return
    for at_s, rss_mb in found["rss_mb"]:  # type: ignore[attr-defined]
        print(f"{at_s:6.0f} s {rss_mb:8.2f} MB")
    for name, value in found.items():
        if name != "rss_mb":
            print(f"{name:<44}{value}")


def _flags() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--fifo", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _soak(flags: argparse.Namespace, folder: Path) -> dict[str, object]:
    policy, log, port = folder / "policy.onnx", folder / "log.mcap", free_port()
    policy.write_bytes(exported(replace(CONTRACT, rate_hz=RATE_HZ), 3, "Relu"))
    ticks, seconds = round(flags.minutes * 60 * RATE_HZ), flags.minutes * 60
    loop_script = str(Path(__file__).with_name("loop.py"))
    body = [loop_script, "--play", "body", "--port", str(port), "--rates", "200"]
    words = ["-m", "reflexarc", "run", str(policy), "--port", str(port), "--record", str(log)]
    words += ["--shadow", str(policy), "--ticks", str(ticks), "--fifo", str(flags.fifo), "--json"]
    sleeper = ["-c", SLEEPER, str(PERIOD_NS), str(seconds + 5), str(flags.fifo)]
    with (
        _beside("-c", LOAD, ordinary=True),
        _beside(*body, stdin=subprocess.PIPE),
        _beside(*sleeper, stdout=subprocess.PIPE) as alone,
        _beside(*words, stdout=subprocess.PIPE) as loop,
    ):
        rss_mb = _watched(loop)
        assert loop.stdout is not None
        said = json.loads(loop.stdout.read() or '{"ticks": "ended before its time", "phases": {}}')
        alone.terminate()
        missed = [line.split() for line in (alone.stdout or []) if line.count(b" ") == 1]
    skipped, missed_s = _skipped(log), [int(due) // SECOND_NS for due, _ in missed]
    after = [mb for at_s, mb in rss_mb if at_s >= 60] or [mb for _, mb in rss_mb]
    return {
        "rss_mb": rss_mb,
        "growth after the first minute, MB": round(after[-1] - after[0], 2),
        "ticks": said["ticks"],
        "slots that the loop skipped": sum(skipped.values()),
        "of these in a second in which the sleeper missed": _beside_misses(skipped, missed_s, 1),
        "of these in such a minute": _beside_misses(skipped, missed_s, 60),
        "deadlines that the sleeper missed": len(missed),
        "phases, p50 and p99, µs": {
            name: (phase["p50_ns"] / 1e3, phase["p99_ns"] / 1e3)
            for name, phase in said["phases"].items()
        },
        "load": os.getloadavg(),
    }


@contextlib.contextmanager
def _beside(
    *words: str, ordinary: bool = False, **pipes: int
) -> Iterator["subprocess.Popen[bytes]"]:
    """A process of Python beside this one; it ends with the context."""
    command = [sys.executable, *words]
    if ordinary:
        command = ["chrt", "--other", "0", *command]
    with subprocess.Popen(command, **pipes) as process:  # type: ignore[call-overload]
        try:
            yield process
        finally:
            process.kill()


def _watched(loop: "subprocess.Popen[bytes]") -> list[tuple[float, float]]:
    """Resident memory of a process, every ten seconds until it ends: seconds, MB."""
    began_s, found = time.monotonic(), []
    while loop.poll() is None:
        with contextlib.suppress(OSError, AttributeError):
            status = Path(f"/proc/{loop.pid}/status").read_text()
            kib = int(re.search(r"VmRSS:\s+(\d+)", status)[1])  # type: ignore[index]
            found.append((time.monotonic() - began_s, kib * 1.024e-3))
        with contextlib.suppress(subprocess.TimeoutExpired):
            loop.wait(10.0)
    return found


def _skipped(log: Path) -> Counter[int]:
    """How many slots were skipped in each second of the monotonic clock."""
    skipped: Counter[int] = Counter()
    last_slot = None
    for record in read_log(log).records("/robot0/tick"):
        tick = pb.Tick.FromString(record.payload)
        slot = tick.decision.slot
        if last_slot is not None and slot > last_slot + 1:
            due_ns = tick.decision.now_ns - tick.timing.receive_ns - tick.timing.lateness_ns
            for missing in range(last_slot + 1 - slot, 0):
                skipped[(due_ns + missing * PERIOD_NS) // SECOND_NS] += 1
        last_slot = slot or last_slot
    return skipped


def _beside_misses(skipped: Counter[int], missed_s: list[int], length_s: int) -> int:
    """How many slots were skipped in a stretch of time in which the sleeper missed a deadline."""
    stretches = {second // length_s for second in missed_s}
    return sum(n for second, n in skipped.items() if second // length_s in stretches)


if __name__ == "__main__":
    main()
