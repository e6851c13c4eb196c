"""Whatever ends a drive on ROS 2, how soon does the robot stand, and how far does it roll?

    python benchmarks/ros2.py [--runs 20] [--seed 1] [--json] [-- FLAGS OF reflexarc ros2]

One robot that scans 50 times a second and one `reflexarc run --input scan`; for each run a
`reflexarc ros2` between them, which is ended at a random moment while the robot drives at 1 m/s.
The motion is computed from the twists that came (tests/support/ros2_base.py): a base with inertia
that brakes with 2 m/s² and holds its last twist for ever, and the same with a time-out of 0.5 s.
From 1 m/s to standstill alone such a base takes 500 ms and 250 mm. "first standstill" is the first
twist of zero after the end, "silent" how long the bus was quiet at the end of a run: a person can
drive. With -- FLAGS other flags than the usual ones are measured (-- --no-companion …). Beside
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
from dataclasses import asdict, dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.body.ros2.messages import decode_scan, encode_scan
from support.policies import exported  # found by the line above
from support.processes import started, wait_until
from support.ros2 import laser_scan
from support.ros2_base import HOLDS_FOR_EVER, WITH_TIMEOUT, rolled
from support.ros2_drives import FAST_ENOUGH, Drive, bridged, kill_group, silence_s
from support.ros2_robot import Robot, free_port, robot

WATCH_S = 3.0
"""So long after its end a drive is watched: longer than a companion speaks."""
REPEATS = 2000

Ending = Callable[[Drive], int]
"""Ends a drive; the time just before, wall clock, ns."""


@dataclass(frozen=True)
class Outcome:
    """What came of one end."""

    first_standstill_ms: float
    holding_ms: float
    holding_mm: float
    timeout_ms: float
    timeout_mm: float
    silent_ms: float


def _kill_companion_then_bridge(drive: Drive) -> int:
    """The worst case: nobody is left, and only a time-out of the base's own helps."""
    if drive.companion:
        os.kill(drive.companion, signal.SIGKILL)
    return kill_group(drive.bridge, signal.SIGKILL)


ENDINGS: dict[str, Ending] = {
    "SIGKILL of the bridge's group": lambda drive: kill_group(drive.bridge, signal.SIGKILL),
    "SIGSTOP of the bridge's group": lambda drive: kill_group(drive.bridge, signal.SIGSTOP),
    "SIGHUP": lambda drive: kill_group(drive.bridge, signal.SIGHUP),
    "SIGTERM": lambda drive: kill_group(drive.bridge, signal.SIGTERM),
    "SIGKILL of companion and bridge": _kill_companion_then_bridge,
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("flags", nargs="*", default=[*map(str, FAST_ENOUGH), "--auto-arm"])
    arguments = parser.parse_args()
    outcomes = _campaign(arguments.runs, random.Random(arguments.seed), arguments.flags)
    if arguments.json:
        print(json.dumps({name: [asdict(one) for one in each] for name, each in outcomes.items()}))
        return
    _print(outcomes)
    print(f"\na scan of 181 beams, µs: {_conversion_us():.1f}")


def _campaign(runs: int, chance: random.Random, flags: list[str]) -> dict[str, list[Outcome]]:
    """The ends in turns, so that a slow minute disturbs all alike."""
    outcomes: dict[str, list[Outcome]] = {name: [] for name in ENDINGS}
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        policy = Path(folder) / "policy.onnx"
        policy.write_bytes(exported(PolicyContract(), seed=5))
        with (
            robot(port, "scan", "cmd_vel", stamped=False) as body,
            started("run", policy, "--input", "scan", "--port", port),
        ):
            for _ in range(runs):
                for name, ending in ENDINGS.items():
                    outcomes[name].append(_end(body, port, ending, chance, flags))
    return outcomes


def _end(
    body: Robot, port: int, ending: Ending, chance: random.Random, flags: list[str]
) -> Outcome:
    with bridged(body, port, *flags) as drive:
        time.sleep(chance.uniform(0.0, 0.1))
        ended_ns = ending(drive)
        time.sleep(WATCH_S)
        until_ns = time.time_ns()
        told, silent_ms = list(body.told), 1e3 * silence_s(body.told)
    after = [word for word in told if word.arrived_ns > ended_ns and word.is_standstill]
    holding = rolled(HOLDS_FOR_EVER, told, ended_ns, until_ns)
    timeout = rolled(WITH_TIMEOUT, told, ended_ns, until_ns)
    wait_until(lambda: silence_s(body.told) > 0.1, "all are silent")
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
