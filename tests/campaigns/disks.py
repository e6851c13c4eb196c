"""Disks that fail under `run --record`: is it said, does the loop notice, what is left?

    python tests/campaigns/disks.py [--only WORD] [--json]

As root, in a mount namespace of its own. Each row starts two runtimes, one that records to a small
disk and one that does not, each with a body that shows 50 retinas a second; three seconds later
the disk fails. The gaps are the longest between two ticks from then on, on the loop's own clock, of
both in the same seconds. Exit status 1: a gap more than 40 ms longer than without a recorder, not
said within 2 s, another exit status than expected, or a part that does not recover and replay.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.messages.topics import STATUS, TICK
from reflexarc_runtime.messages.wire import Message
from support.disk_faults import FAULTS, DiskFault, limited, mounted
from support.fault_runs import free_ports
from support.plain_body import plain_body
from support.policies import exported

INSIDE = "--in-namespace"
MORE_GAP_MS = 40.0
SAID_WITHIN_S = 2.0
BEFORE_S, AFTER_S, RESUMED_S = 3.0, 4.0, 12.0
PATIENCE_S = 60.0


@dataclass
class Heard:
    """What a runtime says."""

    ticks_ns: list[int] = field(default_factory=list)
    statuses: list[tuple[int, str]] = field(default_factory=list)

    def hear(self, message: Message) -> None:
        if message.key.endswith(TICK.name):
            self.ticks_ns.append(pb.Tick.FromString(message.payload).decision.now_ns)
        else:
            status = pb.Status.FromString(message.payload)
            if status.node == "runtime":
                self.statuses.append((message.received_ns, status.recording))

    def longest_gap_ms(self, since_ns: int, until_ns: int) -> float:
        times = [t for t in self.ticks_ns if since_ns <= t <= until_ns]
        return max((b - a for a, b in pairwise(times)), default=0) / 1e6

    def said_ns(self, words: str, since_ns: int) -> int | None:
        found = (t for t, said in self.statuses if t >= since_ns and words in said)
        return next(found, None)


@dataclass
class Row:
    """What a fault showed."""

    name: str
    gap_ms: float = 0.0
    gap_without_ms: float = 0.0
    said_after_s: float | None = None
    said: str = ""
    resumed: bool = False
    exit_status: int | None = None
    parts: list[str] = field(default_factory=list)
    messages: int = 0
    ticks_replayed: int = 0
    failures: list[str] = field(default_factory=list)


def run_fault(fault: DiskFault, folder: Path) -> Row:
    """One row."""
    row = Row(fault.name)
    policy = folder / "policy.onnx"
    policy.write_bytes(exported(PolicyContract(), seed=5))
    ports = free_ports(2)
    with mounted(fault.kind, fault.size_mib, folder) as disk, ExitStack() as stack:
        heard = [_heard(stack, port) for port in ports]
        words = ["--record", disk.log, *fault.flags]
        run = _runtime(stack, fault, policy, ports[0], words)
        _runtime(stack, None, policy, ports[1], [])
        _wait(lambda: all(len(each.ticks_ns) > 10 for each in heard))
        time.sleep(BEFORE_S)
        struck_ns = time.monotonic_ns()
        fault.strike(disk, run.pid)
        _watch(fault, row, heard[0], time.monotonic_ns() if fault.limit_bytes else struck_ns)
        if fault.mend is not None:
            fault.mend(disk, run.pid)
        if fault.resumes:
            resumed = lambda: heard[0].said_ns("again in", struck_ns) is not None  # noqa: E731  # read once
            row.resumed = _wait(resumed, RESUMED_S)
            time.sleep(1.5)
        ended_ns = time.monotonic_ns()
        row.gap_ms, row.gap_without_ms = (h.longest_gap_ms(struck_ns, ended_ns) for h in heard)
        run.send_signal(signal.SIGINT)
        said, complaint = run.communicate(timeout=PATIENCE_S)
        row.exit_status = run.returncode
        _count(row, json.loads(said.splitlines()[-1]) if said else {}, disk.mount, folder)
        _judge(fault, row, complaint)
    return row


def _heard(stack: ExitStack, port: int) -> Heard:
    heard = Heard()
    stack.enter_context(plain_body(PolicyContract(), port))
    bus = stack.enter_context(Bus(BusConfig(port=port), time.monotonic_ns))
    bus.subscribe([TICK, STATUS], heard.hear)
    return heard


def _runtime(
    stack: ExitStack, fault: DiskFault | None, policy: Path, port: int, words: list[Any]
) -> "subprocess.Popen[str]":
    command = [sys.executable, "-m", "reflexarc", "run", policy, "--no-guard", "--json"]
    prefix = fault.prefix if fault else ()
    process = subprocess.Popen(
        [*map(str, (*prefix, *command, "--port", port, *words))],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=limited(fault.limit_bytes)
        if fault
        else None,  # no threads of ours hold locks there
    )
    stack.callback(_killed, process)
    return process


def _killed(process: "subprocess.Popen[str]") -> None:
    if process.poll() is None:
        process.kill()
    process.communicate()


def _watch(fault: DiskFault, row: Row, heard: Heard, struck_ns: int) -> None:
    _wait(lambda: heard.said_ns(fault.says, struck_ns) is not None, AFTER_S)
    said_ns = heard.said_ns(fault.says, struck_ns)
    if said_ns is not None:
        row.said_after_s = (said_ns - struck_ns) / 1e9
        row.said = next(said for t, said in heard.statuses if t == said_ns)
    time.sleep(max(0.0, AFTER_S - (time.monotonic_ns() - struck_ns) / 1e9))


def _wait(holds: Callable[[], bool], patience_s: float = PATIENCE_S) -> bool:
    end_s = time.monotonic() + patience_s
    while not holds():
        if time.monotonic() > end_s:
            return False
        time.sleep(0.02)
    return True


def _count(row: Row, said: dict[str, Any], mount: Path, folder: Path) -> None:
    """Recover what is not finished, and replay every part."""
    row.parts = [Path(part).name for part in said.get("parts", [])]
    kept = {Path(part) for part in said.get("parts", [])}
    kept |= {path for path in mount.rglob("*.mcap*") if path.is_file()}
    for number, path in enumerate(sorted(kept)):
        if path.read_bytes()[:5] != b"\x89MCAP":
            continue
        log = path
        try:
            if path.suffix == ".partial":
                log = folder / f"recovered-{number}.mcap"
                row.messages += recover(path, log).messages
            report = replay(log)
            row.ticks_replayed += next((lv.ticks for lv in report.levels if lv.level == "node"), 0)
            if report.exit_status:
                row.failures.append(f"{path.name} does not replay")
        except ReflexarcError as error:
            row.failures.append(str(error))


def _judge(fault: DiskFault, row: Row, complaint: str) -> None:
    more_ms = row.gap_ms - row.gap_without_ms
    late = row.said_after_s is None or row.said_after_s > SAID_WITHIN_S
    row.failures += [
        f"gap {more_ms:.0f} ms more" * (more_ms > MORE_GAP_MS),
        "not said within 2 s" * late,
        f"exit status {row.exit_status}: {complaint[-300:]}"
        * (row.exit_status != fault.exit_status),
        "no new part" * (fault.resumes and not row.resumed),
        "nothing is left" * (fault.keeps and not row.ticks_replayed),
    ]
    row.failures = [failure for failure in row.failures if failure]


def main() -> int:
    """Run the rows, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", default="", help="rows whose names hold this word")
    parser.add_argument("--json", action="store_true")
    parser.add_argument(INSIDE, action="store_true", help=argparse.SUPPRESS)
    flags = parser.parse_args()
    if not flags.in_namespace:
        words = ["unshare", "-m", sys.executable, __file__, INSIDE, *sys.argv[1:]]
        os.execvp(words[0], words)
    rows = []
    for fault in (fault for fault in FAULTS if flags.only in fault.name):
        with tempfile.TemporaryDirectory() as folder:
            row = run_fault(fault, Path(folder))
        rows.append(row)
        print(json.dumps(asdict(row)) if flags.json else _line(row), flush=True)
    return int(any(row.failures for row in rows))


def _line(row: Row) -> str:
    after = "never" if row.said_after_s is None else f"{row.said_after_s:.1f} s"
    return (
        f"{row.name:17} gap {row.gap_ms:5.0f} ms ({row.gap_without_ms:3.0f} without)  said {after}:"
        f" {row.said!r}  exit {row.exit_status}  {len(row.parts)} parts, {row.messages} recovered,"
        f" {row.ticks_replayed} ticks replayed  {'; '.join(row.failures) or 'ok'}"
    )


if __name__ == "__main__":
    sys.exit(main())
