"""How long does `reflexarc run` take until a body has its first command, and how large is it then?

    python benchmarks/start.py [--rounds 7] [--json] [-- FLAGS OF reflexarc run]

A body waits already: a bare Zenoh subscriber that listens for commands and sends retinas at 50 Hz.
In turns: the runtime, from its start to the first command and to the first one that drives; and
Python with the libraries that no such program can do without, from its start to its end. Medians,
after a round that is not counted: it compiles what pip would have compiled. The memory is what the
kernel says of the process, with its recorder, after some seconds. Nothing is asserted.
"""

import argparse
import json
import os
import re
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.messages.codec import decode_command, encode_retina
from reflexarc_runtime.messages.topics import COMMAND, RETINA
from reflexarc_runtime.messages.wire import Message
from support.bytecode import keep_bytecode  # found by the line above
from support.policies import exported
from support.recordings import CONTRACT, smooth_retinas
from support.ros2_robot import free_port

LEAST = "import zenoh, numpy, onnx, mcap"
PERIOD_S = 0.02


class Body:
    """Sends retinas, and notes when the first commands came."""

    def __init__(self, bus: Bus) -> None:
        self.any, self.driving = threading.Event(), threading.Event()
        self.came_s: dict[str, float] = {}
        self._retinas, self._sent = smooth_retinas(512), 0
        self._publisher = bus.publisher(RETINA)
        bus.subscribe([COMMAND], self._hear)

    def wait(self, event: threading.Event, patience_s: float = 30.0) -> None:
        """Send retinas until it is so."""
        end_s = time.monotonic() + patience_s
        while not event.wait(PERIOD_S) and time.monotonic() < end_s:
            now_ns = time.monotonic_ns()
            retina = self._retinas[self._sent % len(self._retinas)]
            self._publisher.put(encode_retina(retina, CONTRACT.retina, now_ns), now_ns)
            self._sent += 1

    def _hear(self, message: Message) -> None:
        self.came_s.setdefault("any", time.monotonic())
        self.any.set()
        command = decode_command(message.payload)
        if command is not None and not command.is_safe:
            self.came_s.setdefault("driving", time.monotonic())
            self.driving.set()


def main() -> None:
    """Measure in turns, and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--memory-s", type=float, default=10.0)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("flags", nargs="*")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        keep_bytecode(Path(folder) / "bytecode")
        _round(Path(folder), arguments.flags)
        rounds = [_round(Path(folder), arguments.flags) for _ in range(arguments.rounds)]
        memory = _memory(Path(folder), arguments.memory_s, arguments.flags)
    figures = {name: statistics.median(each[name] for each in rounds) for name in rounds[0]}
    figures |= memory
    if arguments.json:
        print(json.dumps(figures))
        return
    print(f"load average {os.getloadavg()[0]:.1f}")
    for name, value in figures.items():
        print(f"{name:<44}{value:>8.3f}")


def _round(folder: Path, flags: list[str]) -> dict[str, float]:
    began_s = time.monotonic()
    subprocess.run([sys.executable, "-c", LEAST], check=True)
    least_s = time.monotonic() - began_s
    port = free_port()
    with Bus(BusConfig(port=port, listens=True), time.monotonic_ns) as bus:
        body = Body(bus)
        began_s = time.monotonic()
        with _started(folder, port, flags) as process:
            body.wait(body.driving)
            process.terminate()
            process.wait()
    return {
        f"python -c '{LEAST}', s": least_s,
        "to the first command, s": body.came_s["any"] - began_s,
        "to the first that drives, s": body.came_s["driving"] - began_s,
    }


def _memory(folder: Path, seconds: float, flags: list[str]) -> dict[str, float]:
    port = free_port()
    with Bus(BusConfig(port=port, listens=True), time.monotonic_ns) as bus:
        body = Body(bus)
        with _started(folder, port, [*flags, "--record", str(folder / "log.mcap")]) as process:
            body.wait(body.driving)
            body.wait(threading.Event(), seconds)
            status = Path(f"/proc/{process.pid}/status").read_text()
            process.terminate()
            process.wait()
    kib = {name: int(value) for name, value in re.findall(r"(Vm\w+|Rss\w+):\s+(\d+) kB", status)}
    return {
        f"resident after {seconds:g} s with recorder, MB": kib["VmRSS"] * 1.024e-3,
        "of it no file's, MB": kib["RssAnon"] * 1.024e-3,
        "at most so far, MB": kib["VmHWM"] * 1.024e-3,
    }


def _started(folder: Path, port: int, flags: list[str]) -> "subprocess.Popen[bytes]":
    policy = folder / "policy.onnx"
    if not policy.exists():
        policy.write_bytes(exported(CONTRACT, 3, "Relu"))
    words = [sys.executable, "-m", "reflexarc", "run", str(policy), "--port", str(port), *flags]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
