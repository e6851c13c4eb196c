"""Ten robots on one machine: is each rate held, and is what was seen of them true?

    python tests/campaigns/ten_robots.py [--robots 10] [--minutes 10] [--keep FOLDER] [--json]

One `reflexarc sim --robots`, and a `reflexarc run --record` for each, all at 50 Hz on one bus. A
witness keeps every status, command and lease. Each log must replay at both levels, and say of each
moment what the witness saw then. A slot that was skipped needs the kernel's word that the processor
was somebody else's. Exit status 1: something seen was not so, a log does not replay, or a slot was
skipped without such a word.
"""

import argparse
import json
import os
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Collection
from contextlib import ExitStack
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.reading.recover import recover
from reflexarc_runtime.contract.contract import PolicyContract
from support.failure_table import failure_table
from support.fault_runs import free_ports
from support.fleet_judge import MS, LoggedRobot, SeenRobot, gaps_ms, seen_of_top, spread, untrue
from support.fleet_logs import fault_of, logged_robot
from support.fleet_witness import FleetWitness, fleet_witness
from support.policies import exported
from support.processes import Process, finished, reflexarc, started, wait_until
from support.processor_account import Waits, memory_mb, processor_s

PERIOD_NS = 20 * MS
SETTLED_S = 5.0
"""From the first tick of the last robot on: what is counted begins behind the start of all."""
JOINS_WITHIN_S = 240.0
TIMER_NS = 650 * MS
"""The kernel's timer ends a runtime whose loop was not there for so long."""


@dataclass
class Fleet:
    """The processes of a campaign."""

    sim: Process
    runs: dict[str, Process]
    logs: dict[str, Path]

    @property
    def pids(self) -> dict[str, int]:
        """All of them, by name."""
        return {"sim": self.sim.pid, **{name: run.pid for name, run in self.runs.items()}}


@dataclass(frozen=True)
class Measured:
    """What was measured while the fleet drove."""

    from_ns: int
    to_ns: int
    processor_s: dict[str, Counter[str]]
    memory_mb: dict[str, list[dict[str, float]]]
    """By process: behind the first minute, and at the end."""
    top: list[SeenRobot]
    load: float


def start_fleet(
    stack: ExitStack, robots: int, port: int, folder: Path, obeying: Callable[[], Collection[str]]
) -> Fleet:
    """Bodies in one process, a runtime each; `obeying` says which bodies obey somebody."""
    policy = folder / "policy.onnx"
    policy.write_bytes(exported(PolicyContract(), seed=5))
    many = ("--robots", robots) if robots > 1 else ()
    sim = ("sim", *many, "--policy", policy, "--port", port, "--state", folder, "--json")
    body = stack.enter_context(started(*sim))
    names = [f"robot{number}" for number in range(robots)]
    logs = {name: folder / f"{name}.mcap" for name in names}
    run = ("run", policy, "--no-guard", "--port", port, "--json", "--record")
    runs = {}
    for name, log in logs.items():  # one behind the other, as a manager starts services in order
        runs[name] = stack.enter_context(started(*run, log, "--robot", name))
        wait_until(lambda: name in obeying() or ended(runs[name]), name, JOINS_WITHIN_S)  # noqa: B023
    return Fleet(body, runs, logs)


def ended(process: Process) -> bool:
    """Whether a process has ended."""
    return process.poll() is not None


def measure(fleet: Fleet, minutes: float, port: int) -> Measured:
    """Let them drive, and look."""
    pids, begun_ns = fleet.pids, time.monotonic_ns()
    before = {name: processor_s(pid) for name, pid in pids.items()}
    settle_s = min(60.0, 20.0 * minutes)
    time.sleep(settle_s)
    memory = {name: [memory_mb(pid)] for name, pid in pids.items()}
    time.sleep(60.0 * minutes - settle_s)
    for name, pid in pids.items():
        memory[name].append(memory_mb(pid))
    took = {name: processor_s(pid) - before[name] for name, pid in pids.items()}
    memory = {name: looks for name, looks in memory.items() if all(looks)}
    took = {name: spent for name, spent in took.items() if name in memory}
    ended_ns = time.monotonic_ns()
    return Measured(begun_ns, ended_ns, took, memory, top(port), os.getloadavg()[1])


def top(port: int) -> list[SeenRobot]:
    """What `reflexarc top` says now; nothing where there is no such command."""
    said = reflexarc("top", "--once", "--json", "--port", port)
    if said.returncode != 0:
        return []
    return seen_of_top(json.loads(said.stdout), time.monotonic_ns())


def campaign(robots: int, minutes: float, folder: Path) -> dict[str, Any]:
    """Start, measure, end, judge."""
    (port,) = free_ports(1)
    with ExitStack() as stack:
        witness = stack.enter_context(fleet_witness(port))
        fleet = start_fleet(stack, robots, port, folder, witness.obeying)
        time.sleep(SETTLED_S)
        waits = Waits(fleet.pids)
        measured = measure(fleet, minutes, port)
        waits.end()
        ends = [end_of(name, fleet, waits) for name in fleet.runs]
        journeys = finished(fleet.sim, signal.SIGINT)
    logged = {name: logged_robot(log) for name, log in fleet.logs.items()}
    contacts = {name: one["contacts"] for name, one in journeys.items()} if robots > 1 else journeys
    return {
        **_rates(logged, measured, waits),
        **_commands(witness, measured),
        **_costs(measured),
        "load, 5 minutes": measured.load,
        "ended by itself": [words for words in ends if words],
        "contacts": contacts,
        **_truth(witness.seen_since(measured.from_ns), logged, "statuses"),
        **_truth(measured.top, logged, "top"),
        "broken logs": [said for log in fleet.logs.values() if (said := fault_of(log))],
    }


def end_of(name: str, fleet: Fleet, waits: Waits) -> str:
    """End a runtime; if it had ended already, what it said, and a log made of what it left."""
    run, log = fleet.runs[name], fleet.logs[name]
    if run.poll() is None:
        finished(run, signal.SIGINT)
        return ""
    said, complaint = run.communicate()
    partial = log.with_name(log.name + ".partial")
    if partial.exists():
        recover(partial, log)
    waited_ms = waits.last_of(name, TIMER_NS) / MS
    waited = f"its threads had waited {waited_ms:.0f} ms for a processor at last"
    words = f"{said.strip()[-300:]} {complaint.strip()[:900]}"
    return f"{name}: status {run.returncode}, {waited}: {words}"


def _rates(logged: dict[str, LoggedRobot], measured: Measured, waits: Waits) -> dict[str, Any]:
    """Ticks a second by each log, and the slots that were skipped, with the machine's word."""
    rates, skips, unexplained = {}, 0, []
    for name, robot in logged.items():
        within = [
            (wake_ns, slot)
            for wake_ns, slot in zip(robot.wake_ns, robot.slots, strict=True)
            if measured.from_ns <= wake_ns <= measured.to_ns
        ]
        if len(within) < 2:
            continue
        seconds = (within[-1][0] - within[0][0]) / 1e9
        rates[name] = round((len(within) - 1) / seconds, 3)
        for (before_ns, before), (wake_ns, slot) in pairwise(within):
            missed = slot - before - 1
            if missed:
                skips += missed
                excess_ns = wake_ns - before_ns - PERIOD_NS
                evidence_ns = waits.evidence_ns(name, before_ns, wake_ns)
                if evidence_ns < excess_ns // 2:
                    words = f"{excess_ns / MS:.0f} ms late, waited {evidence_ns / MS:.0f} ms"
                    unexplained.append(f"{name}: {missed} slots: {words}")
    return {"rates, Hz": rates, "skipped slots": skips, "unexplained skips": unexplained}


def _commands(witness: FleetWitness, measured: Measured) -> dict[str, Any]:
    gaps: list[float] = []
    for times_ns in witness.commands_ns.values():
        gaps += gaps_ms([t for t in times_ns if measured.from_ns <= t <= measured.to_ns])
    late = sum(gap > 100.0 for gap in gaps)
    return {
        "commands": len(gaps),
        "gaps between commands, ms": spread(gaps),
        "gaps above 100 ms": late,
    }


def _costs(measured: Measured) -> dict[str, Any]:
    """Shares of a core, and memory."""
    seconds = (measured.to_ns - measured.from_ns) / 1e9
    runs = [took for name, took in measured.processor_s.items() if name != "sim"]
    by_thread: Counter[str] = Counter()
    for took in runs:
        by_thread.update(took)
    share = lambda spent_s: round(100.0 * spent_s / seconds, 2)  # noqa: E731  # % of a core
    sim = measured.processor_s["sim"]
    grown = {n: b["rss"] - a["rss"] for n, (a, b) in measured.memory_mb.items() if n != "sim"}
    last = [looks[-1] for name, looks in measured.memory_mb.items() if name != "sim"]
    return {
        "a runtime, % of a core": spread([share(took.total()) for took in runs]),
        "of a runtime, by thread": {n: share(s / len(runs)) for n, s in by_thread.most_common(8)},
        "the bodies, % of a core": share(sim.total()),
        "of the bodies, by thread": {n: share(s) for n, s in sim.most_common(8)},
        "a runtime's memory, MB": spread([one["rss"] for one in last]),
        "of it its own share, MB": spread([one["pss"] for one in last]),
        "grown since the first look, MB": spread(list(grown.values())),
    }


def _truth(seen: list[SeenRobot], logged: dict[str, LoggedRobot], of: str) -> dict[str, Any]:
    wrong = [line for one in seen for line in untrue(one, logged[one.robot])]
    return {f"{of} compared": len(seen), f"untrue of {of}": wrong}


FAILURES = (
    "ended by itself",
    "unexplained skips",
    "untrue of statuses",
    "untrue of top",
    "broken logs",
)


def main() -> int:
    """Run it and print a table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--keep", type=Path, help="keep the logs here")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        report = campaign(arguments.robots, arguments.minutes, folder)
    print(json.dumps(report) if arguments.json else failure_table(report, FAILURES))
    return int(any(report[name] for name in FAILURES))


if __name__ == "__main__":
    sys.exit(main())
