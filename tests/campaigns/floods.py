"""Floods against a live robot: is all bounded, is it said, and does the log replay?

    python tests/campaigns/floods.py [--minutes 10] [--only WORD] [--json]

Each row starts `sim`, `run --record` and `record`, lets a process of its own flood them, and ends
them. Exit status 1: a process died or would not end, grew by more than 256 MiB, or a log does not
replay at level node.
"""

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import ReflexarcError
from support import flooder
from support.fault_runs import free_ports
from support.policies import exported
from support.processes import Process, said_line, started

GROWTH_MB = 256
SETTLE_S = 2.0
SAMPLE_S = 0.1
NODES = ("sim", "run", "record")


def resident_mb(process: Process) -> float:
    """Resident memory of a process; 0 once it has ended."""
    try:
        lines = Path(f"/proc/{process.pid}/status").read_text().splitlines()
    except OSError:
        return 0.0
    return next((int(li.split()[1]) / 1024 for li in lines if li.startswith("VmRSS")), 0.0)


def flood(kind: str, seconds: float, folder: Path) -> dict[str, Any]:
    """One row."""
    (port,) = free_ports(1)
    policy = folder / "policy.onnx"
    policy.write_bytes(exported(PolicyContract(), seed=5))
    log, heard = folder / f"{kind}.mcap", folder / f"{kind}-heard.mcap"
    common = ("--port", port, "--json")
    row: dict[str, Any] = {"kind": kind, "failures": []}
    with ExitStack() as stack:
        sim = stack.enter_context(started("sim", "--policy", policy, *common, cwd=folder))
        said_line(sim, "reference-1")
        loop = started("run", policy, "--no-guard", "--record", log, *common, cwd=folder)
        run = stack.enter_context(loop)
        said_line(run, "watchdog")
        record = stack.enter_context(started("record", "-o", heard, *common, cwd=folder))
        said_line(record, "Ctrl-C")
        nodes = dict(zip(NODES, (sim, run, record), strict=True))
        time.sleep(SETTLE_S)
        _watch(row, nodes, kind, port, seconds)
        time.sleep(SETTLE_S)
        row["end MB"] = {name: round(resident_mb(p)) for name, p in nodes.items()}
        row["said"] = {name: _ended(row, name, nodes[name]) for name in ("run", "record", "sim")}
    _judge(row, log, heard)
    return row


def _watch(
    row: dict[str, Any], nodes: dict[str, Process], kind: str, port: int, seconds: float
) -> None:
    """Flood them, and look at their memory all the while."""
    begin = {name: resident_mb(process) for name, process in nodes.items()}
    words = [sys.executable, flooder.__file__, kind, str(port), str(seconds)]
    row["from ns"] = time.monotonic_ns()
    stranger = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    most, give_up_s = dict(begin), time.monotonic() + seconds + 30
    while stranger.poll() is None and time.monotonic() < give_up_s:
        most = {name: max(most[name], resident_mb(p)) for name, p in nodes.items()}
        time.sleep(SAMPLE_S)
    row["to ns"] = time.monotonic_ns()
    if stranger.poll() is None:
        stranger.kill()
    said = stranger.communicate()[0]
    reached = json.loads(said) if said else {"sent": 0, "seconds": seconds}
    row["sent"], row["rate Hz"] = reached["sent"], round(reached["sent"] / reached["seconds"])
    row["begin MB"] = {name: round(value) for name, value in begin.items()}
    row["most MB"] = {name: round(value) for name, value in most.items()}
    for name, process in nodes.items():
        if process.poll() is not None:
            row["failures"].append(f"{name} died: {process.returncode}")
        if most[name] - begin[name] > GROWTH_MB:
            row["failures"].append(f"{name} grew from {begin[name]:.0f} to {most[name]:.0f} MB")


def _ended(row: dict[str, Any], name: str, process: Process) -> dict[str, Any]:
    """What it printed at its end, and how often it said that it was flooded."""
    process.send_signal(signal.SIGINT)
    try:
        said, complaint = process.communicate(timeout=30)
    except subprocess.TimeoutExpired:
        row["failures"].append(f"{name} does not end")
        process.kill()
        return {}
    if process.returncode:
        row["failures"].append(f"{name}: {process.returncode}: {complaint[-300:]}")
    words = ("flooded", "dropped")
    notices = sum(any(word in line for word in words) for line in complaint.splitlines())
    return {"notices": notices, **(json.loads(said.splitlines()[-1]) if said else {})}


def _judge(row: dict[str, Any], log: Path, heard: Path) -> None:
    row["log MB"] = {p.name: round(p.stat().st_size / 1e6, 1) for p in (log, heard) if p.exists()}
    try:
        row["replay"] = replay(log).exit_status
        read = read_log(log)
    except ReflexarcError as error:
        row["failures"].append(str(error))
        return
    if row["replay"]:
        row["failures"].append(f"replay: {row['replay']}")
    begin_ns, end_ns = row["from ns"], row["to ns"]
    decisions = [t.decision for t in read.ticks() if begin_ns <= t.decision.now_ns <= end_ns]
    gaps_ms = np.diff([d.now_ns for d in decisions]) / 1e6
    percentiles = np.percentile(gaps_ms, [50, 99, 100])
    row["gap ms"] = [round(float(value), 1) for value in percentiles]
    row["verdicts"] = dict(Counter(Verdict(d.verdict).name for d in decisions))
    own = ("/robot0/status", "/robot0/lease")
    strangers = b"a stranger, 16 b".hex()
    for record in read.records(*own):
        if record.topic == own[0] and (status := pb.Status.FromString(record.payload)):
            where = row.setdefault("overflows", {})
            if status.node == "body":
                where[status.node] = int(status.inbox_overflows)
                row["refused"] = dict(status.verdicts)
        elif record.topic == own[1]:
            lease = pb.Lease.FromString(record.payload)
            if lease.holder.hex() != strangers:
                row["epoch"] = int(lease.epoch)


def table(rows: list[dict[str, Any]]) -> str:
    """The rows for a person, as Markdown."""
    lines = [
        "| flood | sent | a second | gap ms: p50, p99, max | MB: sim, run, record: begin → most → "
        "end | verdicts | refused by the body | dropped by the body's inbox | epoch | notices: "
        "sim, run, record | log MB: run, record | replay |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += ["| " + " | ".join(map(str, _cells(row))) + " |" for row in rows]
    lines += [f"FAILED {row['kind']}: {what}" for row in rows for what in row["failures"]]
    return "\n".join(lines)


def _cells(row: dict[str, Any]) -> list[Any]:
    memory = "; ".join(
        " → ".join(str(row[f"{when} MB"][node]) for when in ("begin", "most", "end"))
        for node in NODES
    )
    notices = ", ".join(str(row["said"].get(node, {}).get("notices", "?")) for node in NODES)
    return [
        row["kind"],
        row["sent"],
        row["rate Hz"],
        ", ".join(map(str, row.get("gap ms", []))),
        memory,
        _counts(row.get("verdicts", {})),
        _counts(row.get("refused", {})),
        row.get("overflows", {}).get("body", "–"),
        row.get("epoch", "–"),
        notices,
        ", ".join(map(str, row["log MB"].values())),
        row.get("replay", "–"),
    ]


def _counts(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.items()) or "–"


def main() -> int:
    """Run the rows and print a table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--only", default="", help="only floods with this word in their name")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    kinds = [kind for kind in flooder.KINDS if arguments.only in kind]
    if not kinds:
        raise SystemExit(f"--only: expected one of {', '.join(flooder.KINDS)}")
    with tempfile.TemporaryDirectory() as temporary:
        seconds = arguments.minutes * 60 / len(kinds)
        rows = [flood(kind, seconds, Path(temporary)) for kind in kinds]
    print(json.dumps(rows) if arguments.json else table(rows))
    return int(any(row["failures"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
