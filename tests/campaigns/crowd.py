"""Three bodies of one name and three runtimes, started, stopped and killed in random order.

    python tests/campaigns/crowd.py [--minutes 10] [--seed 1] [--json] [--keep FOLDER]

All join one Zenoh router. A witness hears who moves what; see `tests/support/crowd_judge.py`.
Exit status 1: two moved one body, a lonely pair stood, or a log does not replay.
"""

import argparse
import dataclasses
import json
import signal
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import ReflexarcError
from support.crowd_judge import MS, alternations, idle, moved_by_others
from support.crowd_witness import Witness, client_file, router, run_delay_ns, witness
from support.failure_table import failure_table
from support.fault_runs import free_ports
from support.policies import exported
from support.processes import Process, started

SHARES = (1.0, 0.8, 0.6)
"""Ahead speed of each runtime's policy: who moved a body shows in its speed."""
PLACES = [(kind, number) for kind in ("sim", "run") for number in range(3)]
JOINS_WITHIN_S = 30.0
FLUSHED_NS = 1000 * MS
"""A recording that is killed loses less than that."""


@dataclass
class Member:
    """One process, from when it was first heard."""

    process: Process
    sender: bytes
    log: Path | None
    since_ns: int | None
    """None while it is stopped."""
    spans: list[tuple[int, int]] = field(default_factory=list)

    def pause(self, now_ns: int) -> None:
        """It lives no longer, or not for now."""
        if self.since_ns is not None:
            self.spans.append((self.since_ns, now_ns))
        self.since_ns = None


class Crowd:
    """Starts, stops and kills, and remembers who lived when."""

    def __init__(self, folder: Path, zenoh_file: Path, seen: Witness, stack: ExitStack) -> None:
        self.here: dict[tuple[str, int], Member] = {}
        self.gone: list[Member] = []
        self.deeds: dict[str, int] = {}
        self._folder, self._zenoh_file, self._seen, self._stack = folder, zenoh_file, seen, stack
        self._policies = [_policy(folder, share) for share in SHARES]

    def act(self, draw: np.random.Generator, lonely: bool) -> None:
        """One deed at one place; `lonely`: rather end whom a lonely pair would not have."""
        self._bury()
        place = PLACES[draw.integers(len(PLACES))]
        member = self.here.get(place)
        alike = [p for p in self.here if p[0] == place[0]]
        if member is None:
            if not (lonely and alike):
                self._count("start", self._start(place))
        elif member.since_ns is None:
            self._continue(member)
        elif lonely and len(alike) == 1:
            return
        else:
            self._harm(member, draw.choice(["SIGINT", "SIGKILL", "SIGSTOP"]))

    def end(self) -> None:
        """End all that live, as an operator does."""
        for member in self.here.values():
            if member.since_ns is None:
                member.process.send_signal(signal.SIGCONT)
            member.pause(time.monotonic_ns())
            member.process.send_signal(signal.SIGINT)
        for member in self.here.values():
            member.process.wait(60)
        self.gone += self.here.values()
        self.here = {}

    def _start(self, place: tuple[str, int]) -> bool:
        kind, number = place
        known = set(self._seen.first_ns)
        words: list[object] = ["--zenoh", self._zenoh_file, "--json"]
        log = None
        if kind == "sim":
            state = self._folder / f"state-{number}"
            words = ["sim", "--policy", self._policies[0], "--rate", 50, "--state", state, *words]
        else:
            log = self._folder / f"run-{number}-{len(self.gone)}-{time.monotonic_ns()}.mcap"
            words = ["run", self._policies[number], "--no-guard", "--record", log, *words]
        process = self._stack.enter_context(_quiet(words))
        end_s = time.monotonic() + JOINS_WITHIN_S
        while not (new := set(self._seen.first_ns) - known):
            if time.monotonic() > end_s:
                process.kill()
                return False
            time.sleep(0.01)
        sender = new.pop()
        self._seen.watched[process.pid] = run_delay_ns(process.pid)
        self.here[place] = Member(process, sender, log, self._seen.first_ns[sender])
        return True

    def _continue(self, member: Member) -> None:
        member.process.send_signal(signal.SIGCONT)
        member.since_ns = time.monotonic_ns()
        self._count("SIGCONT")
        time.sleep(0.1)  # the kernel's timer ends a runtime that stood for too long
        self._bury()

    def _harm(self, member: Member, name: str) -> None:
        member.pause(time.monotonic_ns())
        member.process.send_signal(signal.Signals[name])
        self._count(name)
        if name != "SIGSTOP":
            member.process.wait(60)
            self._bury()

    def _bury(self) -> None:
        for place, member in list(self.here.items()):
            if member.process.poll() is not None:
                if member.since_ns is not None:  # nobody asked it to: its own watchdog, perhaps
                    self._count("ended by itself")
                    last_ns = self._seen.last_ns[member.sender]
                    member.pause(max(member.since_ns, last_ns))
                self._seen.watched.pop(member.process.pid, None)
                self.gone.append(self.here.pop(place))

    def _count(self, deed: str, was_done: bool = True) -> None:
        name = deed if was_done else f"{deed} failed"
        self.deeds[name] = self.deeds.get(name, 0) + 1


def campaign(minutes: float, seed: int, folder: Path) -> dict[str, Any]:
    """Run it; what was seen, and everything that went wrong."""
    draw, end_s = np.random.default_rng(seed), time.monotonic() + 60 * minutes
    (port,) = free_ports(1)
    zenoh_file = client_file(port, folder)
    with router(port), witness(zenoh_file) as seen, ExitStack() as stack:
        crowd = Crowd(folder, zenoh_file, seen, stack)
        while time.monotonic() < end_s:
            for _ in range(draw.integers(1, 8)):
                crowd.act(draw, lonely=bool(draw.integers(2)))
            time.sleep(float(draw.uniform(0.0, 2.0)))
        crowd.end()
    return _report(crowd, seen)


def _report(crowd: Crowd, seen: Witness) -> dict[str, Any]:
    heard = seen.evidence
    lives = {member.sender: member.spans for member in crowd.gone}
    stood, excused, judged_ns = idle(heard, lives, seen.oversleeps)
    runtimes = [member for member in crowd.gone if member.log is not None]
    # What was killed before its first flush has nothing to replay; only that long is excused.
    brief = [m for m in runtimes if sum(b - a for a, b in m.spans) < FLUSHED_NS]
    logs = [m.log for m in runtimes if m.log is not None and m not in brief]
    broken = [said for log in logs if (said := _fault_of_log(log))]
    # The stretches are as long as their consequences: see the witness.
    slept_ms = [(to_ns - from_ns) / MS for from_ns, to_ns in seen.oversleeps]
    return {
        "deeds": crowd.deeds,
        "bodies": len(heard.steps),
        "runtimes": len(runtimes),
        "runtimes that lived less than 1 s": len(brief),
        "steps": sum(map(len, heard.steps.values())),
        "moving steps": sum(s.ahead_mps > 0.02 for steps in heard.steps.values() for s in steps),
        "holders": sum(len({h for _, h in said if h}) for said in heard.leases.values()),
        "lonely pairs, s": round(judged_ns / 1e9, 1),
        "idle, excused": excused,
        "overslept": len(slept_ms),
        "overslept, worst ms with what follows": round(max(slept_ms, default=0.0), 1),
        "logs": len(logs),
        "moved by others": moved_by_others(heard),
        "alternations": alternations(heard),
        "idle": stood,
        "broken logs": broken,
    }


def _fault_of_log(log: Path) -> str:
    """Why a log does not replay at level node; one that a kill left is recovered first."""
    partial = log.with_name(log.name + ".partial")
    try:
        if partial.exists():
            recover(partial, log)
        report = replay(log)
    except ReflexarcError as error:
        return f"{log.name}: {error}"
    levels = {level.level for level in report.levels}
    if report.exit_status == 0 and "node" in levels:
        return ""
    return f"{log.name}: status {report.exit_status}, levels {sorted(levels)}"


def _quiet(words: list[object]) -> Any:
    """A process; what it says stays in its pipe, which a few lines do not fill."""
    return started(*words)


def _policy(folder: Path, share: float) -> Path:
    contract = PolicyContract()
    actions = tuple(
        dataclasses.replace(action, linear_mps=share * action.linear_mps)
        for action in contract.actions
    )
    path = folder / f"policy-{share:g}.onnx"
    path.write_bytes(exported(dataclasses.replace(contract, actions=actions), seed=5))
    return path


FAILURES = ("moved by others", "alternations", "idle", "broken logs")


def main() -> int:
    """Run it and print a table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", type=Path, help="keep the logs here")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        report = campaign(arguments.minutes, arguments.seed, folder)
    print(json.dumps(report) if arguments.json else failure_table(report, FAILURES))
    return int(any(report[name] for name in FAILURES))


if __name__ == "__main__":
    sys.exit(main())
