"""How long after a sensor's message does the command that it led to reach the body?

    python benchmarks/input_latency.py [--rounds 3] [--seconds 4] [--rates 10 50 1000]

A sensor's process sends retinas, each at a time of its own on an absolute schedule, and hears the
commands: the time from its put to its callback, for the commands that name the retina. Between the
two stands, in turns,

- `echo`: a bare Zenoh process in Python, whose callback puts as many bytes as a command has;
- `input`: `reflexarc run --pace input`, with a contract of that rate, guard and watchdog on;
- `rate`: `reflexarc run --pace rate`, which answers at its own time.

All are peers on the loopback interface, as the project's bus has them. `--quicker 1.001` has the
sensor send so much quicker than the contract's rate. Nothing is asserted.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.loop import realtime
from reflexarc_runtime.messages.codec import decode_command, encode_retina
from reflexarc_runtime.messages.topics import COMMAND, RETINA
from reflexarc_runtime.messages.wire import Message
from support.policies import exported  # found by the line above
from support.processes import started
from support.ros2_robot import free_port

RATES_HZ = (10.0, 50.0, 1000.0)
MODES = ("echo", "input", "rate")
FAR = 40
"""Value of a ray: what it sees is far away, so that the guard lets the policy drive."""
COMMAND_BYTES = 90
PATIENCE_S = 60.0

ECHO = """
import sys, threading, time, zenoh
from reflexarc_runtime.loop import realtime
port, size = sys.argv[1], int(sys.argv[2])
config = zenoh.Config()
for key, value in {
    "mode": '"peer"',
    "scouting/multicast/enabled": "false",
    "transport/shared_memory/enabled": "false",
    "listen/endpoints": '["tcp/127.0.0.1:0"]',
    "connect/endpoints": f'["tcp/127.0.0.1:{port}"]',
}.items():
    config.insert_json5(key, value)
realtime.prepare()
session = zenoh.open(config)
publisher = session.declare_publisher(
    "robot0/command", express=True, priority=zenoh.Priority.REAL_TIME,
    congestion_control=zenoh.CongestionControl.DROP)
payload = bytes(size)
def answer(sample):
    publisher.put(payload, attachment=sample.attachment.to_bytes())
subscriber = session.declare_subscriber("robot0/retina", answer)
threading.Event().wait()
"""
"""The bare echo; the attachment says which retina it answers."""


class Sensor:
    """Sends retinas at a rate, and notes when the first command came that names each."""

    def __init__(self, bus: Bus, contract: PolicyContract, *, is_echoed: bool) -> None:
        self._publisher = bus.publisher(RETINA)
        self._spec, self._is_echoed = contract.retina, is_echoed
        self._picture = np.full(contract.retina.shape, FAR, np.uint8)
        self.left_ns: dict[int, int] = {}
        self.came_ns: dict[int, int] = {}
        bus.subscribe([COMMAND], self._hear)

    def send(self, count: int, rate_hz: float) -> None:
        """Send so many retinas, at absolute times; what is late is sent late."""
        period_ns, begin_ns = round(1e9 / rate_hz), time.monotonic_ns()
        for n in range(1, count + 1):
            number, now_ns = self._publisher.next_sequence, time.monotonic_ns()
            payload = encode_retina(self._picture, self._spec, now_ns)
            self.left_ns[number] = now_ns = time.monotonic_ns()
            self._publisher.put(payload, now_ns)
            wait_ns = begin_ns + n * period_ns - time.monotonic_ns()
            if wait_ns > 0:
                time.sleep(wait_ns * 1e-9)

    def _hear(self, message: Message) -> None:
        if self._is_echoed:
            number = int.from_bytes(message.attachment[:8], "little")
        else:
            command = decode_command(message.payload)
            if command is None or command.source_sequence is None:
                return
            number = command.source_sequence
        self.came_ns.setdefault(number, message.received_ns)


def main() -> None:
    """Measure and print."""
    arguments = _arguments()
    found: dict[tuple[float, str], list[tuple[list[float], float]]] = {}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.rounds):
            for rate_hz in arguments.rates:
                for mode in arguments.modes:
                    waits = _measured(mode, rate_hz, Path(folder), arguments)
                    found.setdefault((rate_hz, mode), []).append(waits)
    rows = [
        _row(rate_hz, mode, runs, found.get((rate_hz, "echo"), []))
        for (rate_hz, mode), runs in found.items()
    ]
    if arguments.json:
        print(json.dumps({"rows": rows, "load": os.getloadavg()}))
        return
    print("| sensor, Hz | | p50, µs | p99, µs | beyond the echo | of the runs | answered |")
    print("|---|---|---|---|---|---|---|")
    for row in rows:
        runs = f"p50 {row['p50_least']:.0f} to {row['p50_most']:.0f}"
        share, beyond = f"{row['answered']:.1%}", row["beyond_echo"]
        more = "" if beyond is None else f"{beyond:.0f}"
        print(f"| {row['hz']:g} | {row['mode']} | {row['p50']:.0f} | {row['p99']:.0f} |", end="")
        print(f" {more} | {runs} | {share} |")
    print("load", *(f"{each:.1f}" for each in os.getloadavg()))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=4.0)
    parser.add_argument("--rates", type=float, nargs="+", default=RATES_HZ)
    parser.add_argument("--modes", nargs="+", default=MODES)
    parser.add_argument("--quicker", type=float, default=1.0, help="than the contract's rate")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("flags", nargs="*", help="of reflexarc run, behind --")
    return parser.parse_args()


def _measured(
    mode: str, rate_hz: float, folder: Path, arguments: argparse.Namespace
) -> tuple[list[float], float]:
    """Waits in µs of one run, and which share of the retinas was answered."""
    contract = replace(PolicyContract(), rate_hz=rate_hz, max_input_age_s=max(0.1, 4 / rate_hz))
    port = free_port()
    realtime.prepare()
    with Bus(BusConfig("robot0", port, listens=True), time.monotonic_ns) as bus:
        sensor = Sensor(bus, contract, is_echoed=mode == "echo")
        with _answering(mode, contract, port, folder, arguments.flags):
            sent_hz = rate_hz * arguments.quicker
            _wait_for_answers(sensor, sent_hz)
            first = len(sensor.left_ns)
            sensor.send(max(20, round(arguments.seconds * sent_hz)), sent_hz)
            time.sleep(0.3)
    numbers = [n for n in sensor.left_ns if n >= first]
    answered = [n for n in numbers if n in sensor.came_ns]
    waits_us = [(sensor.came_ns[n] - sensor.left_ns[n]) / 1e3 for n in answered]
    return waits_us, len(answered) / len(numbers)


def _wait_for_answers(sensor: Sensor, rate_hz: float) -> None:
    """Send until half a second was answered."""
    until_s = time.monotonic() + PATIENCE_S
    enough = max(5, round(rate_hz / 2))
    while len(sensor.came_ns) < enough:
        if time.monotonic() > until_s:
            raise SystemExit("input_latency.py: nobody answers")
        sensor.send(max(1, round(rate_hz / 10)), rate_hz)


@contextmanager
def _answering(
    mode: str, contract: PolicyContract, port: int, folder: Path, flags: list[str]
) -> Iterator[None]:
    if mode == "echo":
        words = [sys.executable, "-c", ECHO, str(port), str(COMMAND_BYTES)]
        process = subprocess.Popen(words)
        try:
            yield
        finally:
            process.kill()
            process.wait()
        return
    policy = folder / f"policy-{contract.rate_hz:g}.onnx"
    if not policy.exists():
        policy.write_bytes(exported(contract, seed=5, activation="Relu"))
    words = ["run", policy, "--port", port, "--pace", mode, "--allow-fast", *flags]
    with started(*words):
        yield


def _row(
    rate_hz: float,
    mode: str,
    runs: list[tuple[list[float], float]],
    echoes: list[tuple[list[float], float]],
) -> dict[str, float | str | None]:
    """Medians over the runs; what is beyond the echo, over the rounds, as minutes differ."""
    p50 = [statistics.median(waits) for waits, _ in runs]
    beyond = [
        median - statistics.median(waits) for median, (waits, _) in zip(p50, echoes, strict=False)
    ]
    p99 = [float(np.percentile(waits, 99)) for waits, _ in runs]
    return {
        "hz": rate_hz,
        "mode": mode,
        "p50": statistics.median(p50),
        "p99": statistics.median(p99),
        "p50_least": min(p50),
        "p50_most": max(p50),
        "beyond_echo": statistics.median(beyond) if beyond and mode != "echo" else None,
        "answered": statistics.median(share for _, share in runs),
    }


if __name__ == "__main__":
    main()
