"""How long after a scan does the twist that it led to reach the robot?

    python benchmarks/ros2_latency.py [--scans 500] [--peer] [--json] [-- FLAGS OF reflexarc ros2]

A robot sends a scan every 15 to 25 ms; a stand-in for the runtime takes the newest one every 20 ms
and answers with a command whose speed is the scan's number (so every phase between the two occurs);
`reflexarc ros2` lies between them twice. So a twist names its scan, and the time from one
to the other is measured by one clock. Nothing is asserted.

With --peer the robot is a process of its own that zenoh-ros2-sdk makes, beside a router as
rmw_zenohd starts it; the bridge is told --wire rmw.
"""

import argparse
import json
import random
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import zenoh

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Input, drive_command
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.codec import encode_command
from reflexarc_runtime.messages.topics import COMMAND, SCAN
from reflexarc_runtime.messages.wire import unpack_stamp
from support.processes import started, wait_until  # found by the line above
from support.ros2 import Twist, laser_scan
from support.ros2_robot import free_port, rmw_router, router

PEER = Path(__file__).parents[1] / "tests" / "support" / "sdk_peer.py"
PERIOD_S = 0.02
STEP_MPS = 1e-5
"""A scan's number times this is the speed of its command: below every limit."""
FIRST_MPS = 0.1
VALID_FOR_NS = 100_000_000


class Echo:
    """A stand-in for the runtime: at a fixed rate it answers the newest scan."""

    def __init__(self, bus: Bus) -> None:
        self._bus, self._inbox = bus, Inbox()
        self._publisher = bus.publisher(COMMAND)
        bus.subscribe([SCAN], self._inbox.put)

    def run(self, until: threading.Event) -> None:
        """Answer until told to end."""
        tick = 0
        while not until.wait(PERIOD_S):
            messages, now_ns = self._inbox.drain(time.monotonic_ns)
            if messages:
                stamp = unpack_stamp(messages[-1].attachment)
                echo = Input(stamp.sequence, stamp.time_ns, now_ns, 0)
                motion = Action("go", FIRST_MPS + STEP_MPS * stamp.sequence, 0.0)
                command = drive_command(tick, 0, motion, echo, VALID_FOR_NS, stamp.sender)
                self._publisher.put(encode_command(command), now_ns)
                tick += 1


class Wheels:
    """Notes when each scan left, and when the first twist that names it came."""

    def __init__(self, session: zenoh.Session) -> None:
        self.left_s: list[float] = []
        self.came_s: dict[int, float] = {}
        self.twists = 0
        self._session = session
        self._kept = session.declare_subscriber("cmd_vel", self._hear)

    def scan(self, count: int) -> None:
        """Send so many scans."""
        publisher, jitter = self._session.declare_publisher("scan"), random.Random(7)
        for _ in range(count):
            self.left_s.append(time.monotonic())
            publisher.put(laser_scan([float("inf")] * 181).serialize())
            time.sleep(jitter.uniform(0.75, 1.25) * PERIOD_S)

    def _hear(self, sample: zenoh.Sample) -> None:
        now_s = time.monotonic()
        self.twists += 1
        ahead_mps = Twist.deserialize(sample.payload.to_bytes()).linear.x
        if ahead_mps:
            self.came_s.setdefault(round((ahead_mps - FIRST_MPS) / STEP_MPS), now_s)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scans", type=int, default=500)
    parser.add_argument("--peer", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("flags", nargs="*")
    arguments = parser.parse_args()
    measure = _measure_peer if arguments.peer else _measure
    figures = measure(arguments.scans, arguments.flags)
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:<40}{value:>8.1f}")


def _measure(scans: int, flags: list[str]) -> dict[str, float]:
    port, end = free_port(), threading.Event()
    config = BusConfig("robot0", port)
    with router(port) as session, started("ros2", "--port", port, *flags):
        wheels = Wheels(session)
        with Bus(config, time.monotonic_ns) as bus:
            runtime = threading.Thread(target=Echo(bus).run, args=(end,))
            runtime.start()
            wait_until(lambda: wheels.twists > 0, "the bridge speaks")
            begun_s, before = time.monotonic(), wheels.twists
            wheels.scan(scans)
            end.set()
            rate_hz = (wheels.twists - before) / (time.monotonic() - begun_s)
            runtime.join()
    return _figures(wheels.left_s, wheels.came_s, rate_hz)


def _measure_peer(scans: int, flags: list[str]) -> dict[str, float]:
    port, end = free_port(), threading.Event()
    words = [sys.executable, str(PEER), str(port), str(scans)]
    with (
        rmw_router(port),
        started("ros2", "--wire", "rmw", "--port", port, *flags),
        Bus(BusConfig("robot0", port), time.monotonic_ns) as bus,
    ):
        runtime = threading.Thread(target=Echo(bus).run, args=(end,))
        runtime.start()
        try:
            robot = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True)
        finally:
            end.set()
            runtime.join()
    heard = json.loads(robot.stdout)
    came_s: dict[int, float] = {}
    for now_s, ahead_mps, _ in heard["told"]:
        if ahead_mps:
            came_s.setdefault(round((ahead_mps - FIRST_MPS) / STEP_MPS), now_s)
    seconds = heard["told"][-1][0] - heard["told"][0][0]
    return _figures(heard["left_s"], came_s, len(heard["told"]) / seconds)


def _figures(left_s: list[float], came_s: dict[int, float], rate_hz: float) -> dict[str, float]:
    waits = [1e3 * (came_s[number] - left_s[number]) for number in sorted(came_s)]
    return {
        "scan to twist, ms, median": statistics.median(waits),
        "scan to twist, ms, 99 of 100": statistics.quantiles(waits, n=100)[98],
        "scan to twist, ms, worst": max(waits),
        "twists a second": rate_hz,
        "scans that led to a twist": float(len(waits)),
    }


if __name__ == "__main__":
    main()
