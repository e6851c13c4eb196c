"""A real drive with a hundred swaps, a shadow, stops, faults, overruns and a guard: it replays.

    python tests/campaigns/swaps.py [--swaps 100] [--seed 1] [--backend onnxruntime] [--keep FOLDER]
                                    [--json]

`reflexarc sim --faults` and `reflexarc run --allow-swap --shadow --record` meet on a bus. Policies
are offered to the runtime, at standstill and while it drives; some do not fit, some are made to
harm, some give no number later; on onnxruntime some loop for ever later, until the watchdog ends
their decision. Between them somebody says stop and reset, and the runtime is
stopped for 80 to 150 ms (SIGSTOP). Exit status 1: what must be refused was taken, what fits was
refused, one that neither gave NaN nor looped was rolled back, the runtime ended, or the log does
not replay identically at a level.
"""

import argparse
import json
import os
import signal
import sys
import tempfile
import time
from collections import Counter
from contextlib import ExitStack
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.serving.swapping import SHOWN
from support.fault_runs import free_ports
from support.fleet_judge import MS, spread
from support.offered_policies import Offer, failing, fitting, hanging, refused
from support.policies import exported
from support.processes import Process, finished, said_line, started
from support.processor_account import Waits
from support.swap_operator import Operator, brightness

FAULTS = """
repeat_s = 12.0

[[fault]]
kind = "silence"
begin_s = 3.0
duration_s = 0.3

[[fault]]
kind = "malformed"
begin_s = 6.0
duration_s = 0.2
how = "truncated"

[[fault]]
kind = "loss"
begin_s = 9.0
duration_s = 1.0
share = 0.3
"""
TIMER_NS = 650 * MS
"""The kernel's timer ends a runtime whose loop was not there for so long."""
CALM_NS = 500 * MS
"""For so long behind a SIGSTOP lateness is that of the SIGSTOP."""
LEVELS = {"policy", "node", "shadow"}


def offers(contract: PolicyContract, brightest: float, count: int, backend: str) -> list[Offer]:
    """What is offered, in turn: every fifth is refused, every seventh fails later."""
    good, bad, later = fitting(contract), refused(contract), [failing(contract, brightest)]
    if backend == "onnxruntime":
        later.append(hanging(contract, brightest))
        bad = [one for one in bad if one.kind != "slow"]  # there it is quick enough
    found = []
    for number in range(count):
        if number % 5 == 4:
            found.append(bad[number // 5 % len(bad)])
        elif number % 7 == 6:
            found.append(later[number // 7 % len(later)])
        else:
            found.append(good[number % 2])
    return found


def drive(folder: Path, swaps: int, seed: int, backend: str) -> tuple[Operator, Path]:
    """The drive; who operated it, and its log."""
    contract, (port,) = PolicyContract(), free_ports(1)
    first, shadow, log = folder / "first.onnx", folder / "shadow.onnx", folder / "drive.mcap"
    first.write_bytes(exported(contract, seed=11))
    shadow.write_bytes(exported(contract, seed=12))
    (folder / "faults.toml").write_text(FAULTS)
    sim = ("sim", "--world", "swing", "--seed", 7, "--policy", first, "--state", folder)
    sim = (*sim, "--faults", folder / "faults.toml")
    run = ("run", first, "--allow-swap", "--shadow", shadow, "--record", log)
    run = (*run, "--backend", backend)
    with ExitStack() as stack:
        body = stack.enter_context(started(*sim, "--port", port, "--json"))
        runtime = stack.enter_context(started(*run, "--port", port, "--json"))
        said_line(runtime, "reflexarc run:")
        bus = stack.enter_context(Bus(BusConfig("robot0", port), time.monotonic_ns))
        operator = Operator(bus, runtime, np.random.default_rng(seed))
        listed = offers(contract, brightness(bus), swaps, backend)
        waits = Waits({"runtime": runtime.pid})
        operator.begin()
        for number, offer in enumerate(listed):
            if runtime.poll() is not None:
                break
            operator.offer(offer, standing=number % 3 == 0)
        operator.end()
        waits.end()
        _end(operator, runtime, log, waits)
        finished(body, signal.SIGINT)
    return operator, log


def _end(operator: Operator, runtime: Process, log: Path, waits: Waits) -> None:
    if runtime.poll() is None:
        finished(runtime, signal.SIGINT)
        return
    _, complaint = runtime.communicate()
    waited = f"it had waited {waits.last_of('runtime', TIMER_NS) / MS:.0f} ms for a processor"
    ended = f"the runtime ended, status {runtime.returncode}, {waited}"
    operator.failures.append(f"{ended}: {complaint.strip()[:900]}")
    recover(log.with_name(log.name + ".partial"), log)


def campaign(folder: Path, swaps: int, seed: int, backend: str) -> dict[str, Any]:
    """Drive, replay, count."""
    operator, path = drive(folder, swaps, seed, backend)
    log, asked = read_log(path), operator.asked
    report = replay(path)
    levels = {level.level: f"{level.identical} of {level.compared}" for level in report.levels}
    if report.verdict != "identical" or set(levels) != LEVELS:
        operator.failures.append(f"replay: {report.verdict}: {report.lines()[:8]}")
    return {
        "offered": dict(Counter(one.kind for one in asked)),
        "answered": dict(Counter(one.outcome.lower() for one in asked)),
        "offered while moving": sum(one.while_moving for one in asked),
        "SIGSTOPs": len(operator.paused),
        **_counts(log, operator),
        **_lateness(log, operator),
        "answered within, ms": spread([(one.to_ns - one.from_ns) / MS for one in asked]),
        "replayed": levels,
        "load, 5 minutes": round(os.getloadavg()[1], 1),
        "failures": operator.failures,
    }


def _counts(log: Log, operator: Operator) -> dict[str, Any]:
    ticks = [tick.decision for tick in log.ticks()]
    hands = sum(a.policy_hash != b.policy_hash for a, b in pairwise(ticks))
    back = [tick.reason for tick in ticks if "rolled back to" in tick.reason]
    kinds = {one.policy_hash[:SHOWN]: one.kind for one in operator.asked}
    blamed = Counter(kinds.get(reason.split()[1], "the first one") for reason in back)
    operator.failures += [f"rolled back: {one}" for one in blamed if not one.endswith("later")]
    return {
        "ticks": len(ticks),
        "verdicts": dict(Counter(Verdict(tick.verdict).name for tick in ticks)),
        "changes of hands": hands,
        "rolled back": dict(blamed),
        "of them as a decision was ended": sum("decision was ended" in reason for reason in back),
    }


def _lateness(log: Log, operator: Operator) -> dict[str, Any]:
    """How late the loop woke while a policy was being tried, and while none was."""
    trying, calm = [], []
    spans = [(one.from_ns, one.to_ns) for one in operator.asked]
    held = [(begin_ns, end_ns + CALM_NS) for begin_ns, end_ns in operator.paused]
    for tick in log.ticks():
        at_ns, late_us = tick.decision.now_ns, tick.timing.lateness_ns / 1000
        if any(a <= at_ns <= b for a, b in held):
            continue
        (trying if any(a <= at_ns <= b for a, b in spans) else calm).append(late_us)
    return {
        "late while one is tried, µs": {"ticks": len(trying), **spread(trying)},
        "late while none is, µs": {"ticks": len(calm), **spread(calm)},
    }


def main() -> int:
    """Run it and print a table, or one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--swaps", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--backend", choices=("numpy", "onnxruntime"), default="numpy")
    parser.add_argument("--keep", type=Path, help="keep the log here")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        report = campaign(folder, arguments.swaps, arguments.seed, arguments.backend)
    if arguments.json:
        print(json.dumps(report))
    else:
        print(*(f"{what:<30}{seen}" for what, seen in report.items()), sep="\n")
    return int(bool(report["failures"]))


if __name__ == "__main__":
    sys.exit(main())
