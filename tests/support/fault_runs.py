"""One run of a fault campaign: a real runtime that records, a real faulty body, and a judge."""

import json
import signal
import socket
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.body.faults.random_script import kind_of_seed, random_script
from support.fault_judge import MS, Outage, driving, outages
from support.processes import Process, said_line, started

INPUTS = ("retina", "rejected", "stop", "overrun")
"""Topics whose messages a tick takes from its inbox: on a busy machine its watchdog speaks, too."""
BODY = Path(__file__).with_name("faulty_body.py")
SECONDS = 3.4
PATIENCE_S = 90.0


@dataclass
class Outcome:
    """What one run showed."""

    name: str
    kind: str
    outages: list[Outage] = field(default_factory=list)
    verdicts: dict[str, int] = field(default_factory=dict)
    ticks: int = 0
    sent: int = 0
    recorded: int = 0
    worst_look_ms: float = 0.0
    """How late the body's own process was woken at worst."""
    worst_tick_ms: float = 0.0
    """The same of the runtime's."""
    replayed: bool = False
    failures: list[str] = field(default_factory=list)
    """What must never be."""
    oversleeps: list[str] = field(default_factory=list)
    """Bounds that were missed because the machine did not wake the body."""

    def fail(self, holds: bool, what: str) -> None:
        if not holds:
            self.failures.append(what)


def fault_run(seed: int, policy: Path, port: int, folder: Path) -> Outcome:
    """The script of one seed, from beginning to end."""
    outcome = Outcome(f"seed:{seed}", kind_of_seed(seed))
    log, noted = folder / f"{seed}.mcap", folder / f"{seed}.json"
    with started("run", policy, "--no-guard", "--port", port, "--record", log, "--json") as runtime:
        said_line(runtime, "reflexarc run:")
        with body(port, noted, f"seed:{seed}", SECONDS) as process:
            _end_of(process, outcome)
        _stop(runtime, outcome)
    if not outcome.failures:
        _judge_body(outcome, json.loads(noted.read_text()), seed)
    judge_log(outcome, log)
    return outcome


def killed_body_run(policy: Path, port: int, folder: Path) -> Outcome:
    """`kill -9` of the body, and its return under another identity."""
    outcome = Outcome("kill -9 of the body", "killed body")
    log, noted = folder / "killed-body.mcap", folder / "killed-body.json"
    with started("run", policy, "--no-guard", "--port", port, "--record", log, "--json") as runtime:
        said_line(runtime, "reflexarc run:")
        with body(port, folder / "never.json", "none", 60.0) as first:
            _said_joined(first)
            time.sleep(1.5)
            first.kill()
            first.wait()
        time.sleep(0.5)
        with body(port, noted, "none", 2.0) as second:
            _end_of(second, outcome)
        _stop(runtime, outcome)
    judge_log(outcome, log)
    polls = json.loads(noted.read_text())["polls"] if noted.exists() else []
    outcome.fail(_drives_at_end(polls), "did not drive again after the body's return")
    _judge_silence_in_log(outcome, log)
    return outcome


def killed_runtime_run(policy: Path, port: int, folder: Path) -> Outcome:
    """`kill -9` of the runtime, and its return."""
    outcome = Outcome("kill -9 of the runtime", "killed runtime")
    log, noted, saved = (folder / f"killed-runtime{s}" for s in (".mcap", ".json", "-saved.mcap"))
    again = folder / "killed-runtime-again.mcap"
    with body(port, noted, "none", 9.0) as process:
        with started("run", policy, "--no-guard", "--port", port, "--record", log) as runtime:
            said_line(runtime, "reflexarc run:")
            _said_joined(process)
            time.sleep(1.5)
            runtime.kill()
            runtime.wait()
        with started(
            "run", policy, "--no-guard", "--port", port, "--record", again, "--json"
        ) as runtime:
            said_line(runtime, "reflexarc run:")
            _end_of(process, outcome)
            _stop(runtime, outcome)
    notes: dict[str, Any] = json.loads(noted.read_text()) if noted.exists() else {}
    heard = [(time_ns, time_ns) for time_ns, _, _ in notes.get("heard", [])]
    _judge_outages(outcome, notes.get("polls", []), heard, notes.get("heard", []))
    outcome.fail(bool(outcome.outages), "no outage was seen")
    outcome.fail(_drives_at_end(notes.get("polls", [])), "did not drive again")
    recover(log.with_name(log.name + ".partial"), saved)
    judge_log(outcome, again)
    outcome.fail(_replays(saved), "the killed runtime's recovered log does not replay")
    return outcome


def judge_log(outcome: Outcome, log: Path) -> None:
    """Readable, complete, equal at both levels."""
    try:
        read = read_log(log)
        ticks = list(read.ticks())
        inbox = [f"/{read.run.robot}/{name}" for name in INPUTS]
        outcome.recorded = sum(1 for _ in read.records(*inbox))
        outcome.replayed = _replays(log)
    except ReflexarcError as error:
        outcome.failures.append(f"log: {error}")
        return
    outcome.ticks = len(ticks)
    outcome.verdicts = dict(Counter(Verdict(t.decision.verdict).name for t in ticks))
    outcome.worst_tick_ms = max(t.timing.lateness_ns for t in ticks) / MS
    indices = [tick.decision.index for tick in ticks]
    outcome.fail(read.complete and not read.dropped, "the log is not complete")
    outcome.fail(indices == list(range(len(ticks))), "the log lacks a tick")
    drained = sum(tick.decision.inputs for tick in ticks)
    outcome.fail(drained == outcome.recorded, f"{drained} inputs used, {outcome.recorded} recorded")
    outcome.fail(outcome.replayed, "replay differs")


@contextmanager
def body(port: int, out: Path, script: str, seconds: float) -> Iterator[Process]:
    """A faulty body in a process of its own."""
    words = ["--port", port, "--script", script, "--seconds", seconds, "--out", out]
    process = subprocess.Popen(
        [sys.executable, str(BODY), *map(str, words)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.communicate()


def free_ports(count: int, first: int = 20_000) -> list[int]:
    """Ports that nobody listens on, below those that the system gives to whoever asks for any."""
    found: list[int] = []
    for port in range(first + time.time_ns() % 8000, 32_000):
        with socket.socket() as listener:
            try:
                listener.bind(("127.0.0.1", port))
            except OSError:
                continue
        found.append(port)
        if len(found) == count:
            return found
    raise AssertionError("no free ports")


def _judge_body(outcome: Outcome, notes: dict[str, Any], seed: int) -> None:
    polls, sent, heard = notes["polls"], notes["sent"], notes["heard"]
    outcome.sent = len(sent)
    _judge_outages(outcome, polls, sent, heard)
    begin_ns, script = polls[0][0], random_script(seed)
    first_ns = begin_ns + round(script.faults[0].begin_s * 1e9)
    outcome.fail(driving(polls, begin_ns, first_ns), "did not drive before the faults")
    outcome.fail(_drives_at_end(polls), "did not drive again after the faults")


def _judge_outages(outcome: Outcome, polls: Any, worths: Any, heard: Any) -> None:
    outcome.worst_look_ms = max((late for _, late, _ in polls), default=0) / MS
    outcome.outages = outages(polls, worths, [(time_ns, name) for time_ns, name, _ in heard])
    for outage in outcome.outages:
        if outage.is_late:
            said = f"{(outage.to_safe_ns or 0) / MS:.1f} ms to safe, {outage.oversleep_ns / MS:.1f}"
            where = outcome.oversleeps if outage.is_the_machine_s else outcome.failures
            where.append(f"{said} ms of them overslept")


def _judge_silence_in_log(outcome: Outcome, log: Path) -> None:
    """A dead body notes nothing: the runtime's own ticks say when it stopped."""
    ticks = list(read_log(log).ticks())
    for before, after in pairwise(ticks):
        if before.decision.verdict == Verdict.OK and after.decision.verdict == Verdict.STALE_INPUT:
            last_ns, stop_ns = after.decision.input.received_ns, after.decision.now_ns
            outage = Outage(
                last_ns,
                before.decision.now_ns,
                stop_ns,
                after.timing.lateness_ns,
                Verdict.STALE_INPUT.name,
            )
            outcome.outages.append(outage)
            outcome.fail(not outage.is_late or outage.is_the_machine_s, "told to stop too late")
    outcome.fail(bool(outcome.outages), "no outage was seen")


def _drives_at_end(polls: Any, within_ns: int = 400 * MS) -> bool:
    return bool(polls) and driving(polls, polls[-1][0] - within_ns, polls[-1][0] + 1)


def _replays(log: Path) -> bool:
    report = replay(log)
    return report.exit_status == 0 and {r.level for r in report.levels} == {"policy", "node"}


def _said_joined(process: Process) -> None:
    assert process.stdout is not None
    line = process.stdout.readline()
    assert "joined" in line, "the body did not find the runtime"


def _end_of(process: Process, outcome: Outcome) -> None:
    _, complaint = process.communicate(timeout=PATIENCE_S)
    outcome.fail(process.returncode == 0, f"body: {complaint[-300:]}")


def _stop(runtime: Process, outcome: Outcome) -> None:
    runtime.send_signal(signal.SIGINT)
    said, complaint = runtime.communicate(timeout=PATIENCE_S)
    outcome.fail(runtime.returncode == 0, f"runtime: exit status {runtime.returncode}")
    clean = "Traceback" not in complaint and "panicked" not in complaint
    outcome.fail(clean, f"runtime: {complaint[-600:]}")
    outcome.fail("STOPPED" in said, "the runtime did not say how it went")
