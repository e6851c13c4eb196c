"""How soon does a ROS 2 robot stand when the runtime is killed, and what does the bridge cost?

    python benchmarks/ros2.py [--runs 5] [--json]

Each run: a robot that scans 50 times a second, `reflexarc ros2 --stamped`, `reflexarc run --input
scan`; the runtime gets SIGKILL while it drives. Times are of the commands' own stamps after the
kill: of the last command that drove, and of the first standstill after it. The conversion is a
scan of 181 beams, CDR to `foxglove.LaserScan`. Nothing is asserted.
"""

import argparse
import json
import signal
import socket
import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.body.ros2.messages import decode_scan, encode_scan
from support.policies import exported  # found by the line above
from support.processes import finished, started, wait_until
from support.ros2 import laser_scan
from support.ros2_robot import Robot, robot

STEADY = 25
"""So many commands of one kind in a row are no accident."""
REPEATS = 2000


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        policy = Path(folder) / "policy.onnx"
        policy.write_bytes(exported(PolicyContract(), seed=5))
        kills = [_kill(policy) for _ in range(arguments.runs)]
    figures = {
        "last command that drove, ms after the kill, worst": max(last for last, _ in kills),
        "first standstill, ms after the kill, median": statistics.median(f for _, f in kills),
        "first standstill, ms after the kill, worst": max(first for _, first in kills),
        "a scan of 181 beams, µs": _conversion_us(),
    }
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:<52}{value:>8.1f}")


def _kill(policy: Path) -> tuple[float, float]:
    """Last command that drove and first standstill, in ms after the kill."""
    port = _free_port()
    with (
        robot(port, "scan", "cmd_vel", stamped=True) as body,
        started("ros2", "--stamped", "--json", "--port", port) as bridge,
    ):
        with started("run", policy, "--input", "scan", "--port", port) as runtime:
            wait_until(lambda: _steady(body, standing=False), "the robot drives")
            runtime.kill()
            runtime.wait()
            killed_ns = time.time_ns()
        wait_until(lambda: _steady(body, standing=True), "it stands")
        finished(bridge, signal.SIGINT)
    last_ns = max(word.stamp_ns for word in body.told if not word.is_standstill)
    first_ns = min(w.stamp_ns for w in body.told if w.is_standstill and w.stamp_ns > last_ns)
    return (last_ns - killed_ns) / 1e6, (first_ns - killed_ns) / 1e6


def _steady(body: Robot, standing: bool) -> bool:
    newest = body.told[-STEADY:]
    return len(newest) == STEADY and all(word.is_standstill is standing for word in newest)


def _free_port() -> int:
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def _conversion_us() -> float:
    payload = laser_scan([1.0] * 181).serialize()
    encode_scan(decode_scan(payload))
    begun = time.perf_counter()
    for _ in range(REPEATS):
        encode_scan(decode_scan(payload))
    return (time.perf_counter() - begun) / REPEATS * 1e6


if __name__ == "__main__":
    main()
