"""Whatever ends a drive on ROS 2, how soon does the robot stand, and how far does it roll?

    python benchmarks/ros2.py [--runs 20] [--only WORDS] [--json] [-- FLAGS OF reflexarc ros2]

One robot that scans 50 times a second and one `reflexarc run --input scan`; for each run a
`reflexarc ros2` between them, which is ended at a random moment while the robot drives at 1 m/s.
The motion is computed from the twists that came (tests/support/ros2_base.py): a base with inertia
that brakes with 2 m/s² and holds its last twist for ever, and the same with a time-out of 0.5 s.
From 1 m/s to standstill alone such a base takes 500 ms and 250 mm. "first standstill" is the first
twist of zero after the end, "silent" how long the bus was quiet at the end of a run: a person can
drive. A runtime that is stopped is for the bridge what one that is killed is. With -- FLAGS other
flags than the usual ones are measured (-- --no-companion …), with --only some of the ends. Beside
it: what the conversion of a scan of 181 beams costs. Nothing is asserted.
"""

import argparse
import json
import math
import os
import random
import signal
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.body.ros2.messages import decode_scan, encode_scan
from support.policies import exported  # found by the line above
from support.processes import Process, started, wait_until
from support.ros2 import laser_scan
from support.ros2_base import HOLDS_FOR_EVER, WITH_TIMEOUT, rolled
from support.ros2_drives import FAST_ENOUGH, Drive, bridged, kill_group, silence_s
from support.ros2_robot import free_port, robot

SILENCE_S = 0.1
"""Between two drives."""
WATCH_S = 3.0
"""So long after its end a drive is watched: longer than a companion speaks."""
REPEATS = 2000

Ending = Callable[[Drive, Process], int]
"""Ends a drive, given its runtime as well; the time just before, wall clock, ns."""


@dataclass(frozen=True)
class Outcome:
    """What came of one end."""

    first_standstill_ms: float
    holding_ms: float
    holding_mm: float
    timeout_ms: float
    timeout_mm: float
    silent_ms: float


def _kill_both(drive: Drive, runtime: Process) -> int:
    """The worst case: nobody is left, and only a time-out of the base's own helps."""
    if drive.companion:
        os.kill(drive.companion, signal.SIGKILL)
    return kill_group(drive.bridge, signal.SIGKILL)


def _stop_runtime(drive: Drive, runtime: Process) -> int:
    now_ns = time.time_ns()
    runtime.send_signal(signal.SIGSTOP)
    return now_ns


def _sending(number: signal.Signals) -> Ending:
    """Sends a signal to the bridge and its process group."""
    return lambda drive, runtime: kill_group(drive.bridge, number)


ENDINGS: dict[str, Ending] = {
    "SIGKILL of the bridge's group": _sending(signal.SIGKILL),
    "SIGSTOP of the bridge's group": _sending(signal.SIGSTOP),
    "SIGHUP": _sending(signal.SIGHUP),
    "SIGTERM": _sending(signal.SIGTERM),
    "SIGKILL of companion and bridge": _kill_both,
    "SIGSTOP of the runtime": _stop_runtime,
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("flags", nargs="*", default=[*map(str, FAST_ENOUGH), "--auto-arm"])
    arguments = parser.parse_args()
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup every child would ignore it, rightly
    endings = {name: ending for name, ending in ENDINGS.items() if arguments.only in name}
    chance = random.Random(arguments.seed)
    outcomes = _campaign(endings, arguments.runs, chance, arguments.flags)
    if arguments.json:
        print(json.dumps({name: [asdict(one) for one in each] for name, each in outcomes.items()}))
        return
    _print(outcomes)
    print(f"\na scan of 181 beams, µs: {_conversion_us():.1f}")


def _campaign(
    endings: dict[str, Ending], runs: int, chance: random.Random, flags: list[str]
) -> dict[str, list[Outcome]]:
    """The ends in turns, so that a slow minute disturbs all alike."""
    outcomes: dict[str, list[Outcome]] = {name: [] for name in endings}
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        policy = Path(folder) / "policy.onnx"
        policy.write_bytes(exported(PolicyContract(), seed=5))
        with (
            robot(port, "scan", "cmd_vel", stamped=False) as body,
            started("run", policy, "--input", "scan", "--port", port) as runtime,
        ):
            for _ in range(runs):
                for name, ending in endings.items():
                    drive = bridged(body, port, *flags)
                    outcomes[name].append(_end(drive, runtime, ending, chance))
                    wait_until(lambda: silence_s(body.told) > SILENCE_S, "all are silent")
    return outcomes


def _end(
    driven: AbstractContextManager[Drive], runtime: Process, ending: Ending, chance: random.Random
) -> Outcome:
    with driven as drive:
        time.sleep(chance.uniform(0.0, 0.1))
        ended_ns = ending(drive, runtime)
        time.sleep(WATCH_S)
        until_ns = time.time_ns()
        told, silent_ms = list(drive.body.told), 1e3 * silence_s(drive.body.told)
        runtime.send_signal(signal.SIGCONT)
    after = [word for word in told if word.arrived_ns > ended_ns and word.is_standstill]
    holding = rolled(HOLDS_FOR_EVER, told, ended_ns, until_ns)
    timeout = rolled(WITH_TIMEOUT, told, ended_ns, until_ns)
    return Outcome(
        first_standstill_ms=(after[0].arrived_ns - ended_ns) / 1e6 if after else math.inf,
        holding_ms=1e3 * holding.standstill_s,
        holding_mm=1e3 * holding.distance_m,
        timeout_ms=1e3 * timeout.standstill_s,
        timeout_mm=1e3 * timeout.distance_m,
        silent_ms=silent_ms,
    )


def _print(outcomes: dict[str, list[Outcome]]) -> None:
    heads = ("first standstill", "holds for ever", "time-out 0.5 s", "silent")
    print(f"{'':<33}" + "".join(f"{head:>19}" for head in heads))
    units = ("ms median  worst", "worst ms     mm", "worst ms     mm", "ms, least")
    print(f"{'':<33}" + "".join(f"{unit:>19}" for unit in units))
    for name, each in outcomes.items():
        firsts = [one.first_standstill_ms for one in each]
        print(
            f"{name:<33}{statistics.median(firsts):>12.1f}{max(firsts):>7.1f}"
            f"{max(one.holding_ms for one in each):>12.0f}"
            f"{max(one.holding_mm for one in each):>7.0f}"
            f"{max(one.timeout_ms for one in each):>12.0f}"
            f"{max(one.timeout_mm for one in each):>7.0f}"
            f"{min(one.silent_ms for one in each):>19.0f}"
        )


def _conversion_us() -> float:
    payload = laser_scan([1.0] * 181).serialize()
    encode_scan(decode_scan(payload))
    begun = time.perf_counter()
    for _ in range(REPEATS):
        encode_scan(decode_scan(payload))
    return (time.perf_counter() - begun) / REPEATS * 1e6


if __name__ == "__main__":
    main()
