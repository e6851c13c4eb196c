"""The real loop, `reflexarc run` with a recorder, beside a bare loop of the same work, in turns.

    python benchmarks/loop.py [--rates 1000 50] [--seconds 8] [--rounds 3] [--fifo 50] [--json]

A body in a process of its own sends retinas at 200 Hz (at 50 Hz: 50). The figures of `reflexarc
run` are those of its own log: what each phase of each tick took. The bare loop does the least that
could be called the same: callback into a deque, decode, four NumPy calls over kept buffers, a
command, a put, a tick, and one put of it all into a queue, whose thread compresses it into a file.
Nothing is asserted.
"""

import argparse
import dataclasses
import gc
import json
import os
import queue
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import numpy as np
import zstandard
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.loop import realtime
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import COMMAND, RETINA, TICK
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT, smooth_retinas
from support.ros2_robot import free_port

PHASES = {
    "lateness": lambda t: t.lateness_ns,
    "receive": lambda t: t.receive_ns,
    "decide": lambda t: t.decide_ns,
    "publish": lambda t: t.publish_ns,
    "waking to command": lambda t: t.receive_ns + t.decide_ns + t.publish_ns,
    "handing over the record": lambda t: t.record_ns,
}
WARM = 0.2
"""Share of the ticks, at the beginning, that is left out."""
CHUNK_BYTES = 1 << 16
FREE = 150
"""A ray of 5 m that meets something at 2 m: what the policy wants is free."""


def main() -> None:
    """Measure in turns, and print the table; or be one of the processes of that."""
    flags = _flags()
    if flags.play == "body":
        _body(flags.port, flags.rates[0])
    elif flags.play == "bare":
        _bare(flags.port, flags.rates[0], flags.seconds, flags.fifo, flags.policy)
    else:
        _measure(flags)


def _flags() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rates", type=float, nargs="+", default=[1000.0, 50.0])
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--fifo", type=int, default=0)
    parser.add_argument("--policy", type=Path, help="instead of a network of 16–5–3")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--play", choices=("body", "bare"), help=argparse.SUPPRESS)
    parser.add_argument("--port", type=int, help=argparse.SUPPRESS)
    return parser.parse_args()


def _measure(flags: argparse.Namespace) -> None:
    found: dict[str, dict[str, list[float]]] = {}
    for _ in range(flags.rounds):
        for rate_hz in flags.rates:
            with tempfile.TemporaryDirectory() as folder:
                policy = policy_at(rate_hz, flags.policy, Path(folder))
                for name, phases in (
                    (f"bare loop, {rate_hz:g} Hz", _play_bare(policy, rate_hz, flags)),
                    (f"reflexarc run, {rate_hz:g} Hz", _run(policy, rate_hz, flags)),
                ):
                    rows = found.setdefault(name, {})
                    for phase, us in phases.items():
                        rows.setdefault(phase, []).append(us)
    table = {
        name: {phase: round(statistics.median(us), 2) for phase, us in rows.items()}
        for name, rows in found.items()
    }
    print(json.dumps(table) if flags.json else _in_words(table))


def _in_words(table: dict[str, dict[str, float]]) -> str:
    lines = [f"load average {os.getloadavg()[0]:.1f}; medians over the rounds, µs"]
    for name, rows in table.items():
        lines += ["", name, *(f"  {phase:<32}{us:>10.1f}" for phase, us in rows.items())]
    return "\n".join(lines)


def policy_at(rate_hz: float, given: Path | None, folder: Path) -> Path:
    """A policy of this rate: a network of random weights, or a file as it is."""
    if given is not None:
        return given
    path = folder / "policy.onnx"
    path.write_bytes(exported(dataclasses.replace(CONTRACT, rate_hz=rate_hz), 3, "Relu"))
    return path


@contextmanager
def body_beside(rate_hz: float) -> Iterator[int]:
    """A body in a process of its own; its port."""
    port = free_port()
    words = [sys.executable, __file__, "--play", "body", "--port", str(port)]
    words += ["--rates", str(min(rate_hz, 200.0))]
    with subprocess.Popen(words, stdin=subprocess.PIPE) as body:
        try:
            yield port
        finally:
            body.kill()


def _run(policy: Path, rate_hz: float, flags: argparse.Namespace) -> dict[str, float]:
    """The phases of `reflexarc run`, as its log has them."""
    log = policy.parent / "log.mcap"
    log.unlink(missing_ok=True)
    ticks = str(round(rate_hz * flags.seconds))
    words = [sys.executable, "-m", "reflexarc", "run", str(policy), "--record", str(log)]
    with body_beside(rate_hz) as port:
        words += ["--ticks", ticks, "--port", str(port), "--fifo", str(flags.fifo)]
        subprocess.run(words, check=True, capture_output=True)
    ticks = [pb.Tick.FromString(record.payload) for record in read_log(log).records("/robot0/tick")]
    timings = [tick.timing for tick in ticks[round(WARM * len(ticks)) : -1]]
    return {
        **_percentiles({name: [of(t) for t in timings] for name, of in PHASES.items()}),
        "skipped slots": ticks[-2].decision.slot - len(ticks) + 1,
    }


def _play_bare(policy: Path, rate_hz: float, flags: argparse.Namespace) -> dict[str, float]:
    words = [sys.executable, __file__, "--play", "bare", "--rates", str(rate_hz)]
    words += ["--seconds", str(flags.seconds), "--fifo", str(flags.fifo), "--policy", str(policy)]
    with body_beside(rate_hz) as port:
        done = subprocess.run([*words, "--port", str(port)], check=True, capture_output=True)
    phases: dict[str, float] = json.loads(done.stdout)
    return phases


def _percentiles(phases_ns: dict[str, list[int]]) -> dict[str, float]:
    return {
        f"{name} p{share:g}": float(np.percentile(ns, share)) / 1e3
        for name, ns in phases_ns.items()
        for share in (50, 99)
    }


def _body(port: int, rate_hz: float) -> None:
    """Send retinas until it is ended."""
    spec, retinas = CONTRACT.retina, np.minimum(smooth_retinas(4096), FREE)
    with Bus(BusConfig(port=port, listens=True), time.monotonic_ns) as bus:
        publisher = bus.publisher(RETINA)
        for count, due_s in enumerate(_due_s(rate_hz)):
            time.sleep(max(0.0, due_s - time.monotonic()))
            now_ns = time.monotonic_ns()
            publisher.put(encode_retina(retinas[count % 4096], spec, now_ns), now_ns)


def _due_s(rate_hz: float) -> Iterator[float]:
    begin_s, count = time.monotonic(), 0
    while True:
        yield begin_s + count / rate_hz
        count += 1


class BareLoop:
    """The least that could be called the same work."""

    def __init__(self, bus: Bus, policy: Path) -> None:
        self._inbox: deque[Message] = deque()
        self._queue: queue.SimpleQueue[object] = queue.SimpleQueue()
        self._command, self._tick = bus.publisher(COMMAND), bus.publisher(TICK)
        model = {k: v for k, v in _weights(policy).items() if v.ndim}
        self._w1, self._w2 = (np.ascontiguousarray(model[name].T) for name in ("w1", "w2"))
        self._b1, self._b2 = model["b1"], model["b2"]
        self._hidden, self._q = np.zeros(len(self._b1)), np.zeros(len(self._b2))
        self._seen = np.zeros(len(self._w1))
        bus.subscribe([RETINA], self._inbox.append)
        self._writer = threading.Thread(target=self._write, daemon=True)
        self._writer.start()

    def decide(self, index: int, now_ns: int) -> pb.Command:
        """Decode what came last, and compute."""
        messages = [self._inbox.popleft() for _ in range(len(self._inbox))]
        if messages:
            image = RawImage.FromString(messages[-1].payload)
            np.divide(np.frombuffer(image.data, np.uint8), 255.0, out=self._seen)
        np.matmul(self._seen, self._w1, out=self._hidden)
        np.add(self._hidden, self._b1, out=self._hidden)
        np.maximum(self._hidden, 0.0, out=self._hidden)
        np.matmul(self._hidden, self._w2, out=self._q)
        np.add(self._q, self._b2, out=self._q)
        self._messages = messages
        return pb.Command(sequence=index, action=int(self._q.argmax()), source_time_ns=now_ns)

    def publish(self, command: pb.Command, now_ns: int) -> None:
        """Send the command."""
        self._command.put(command.SerializeToString(), now_ns)

    def record(self, command: pb.Command, now_ns: int) -> None:
        """Hand it all over, and say it on the bus."""
        decision = pb.Decision(index=command.sequence, command=command, now_ns=now_ns)
        tick = pb.Tick(decision=decision).SerializeToString()
        self._queue.put((self._messages, tick))
        self._tick.put(tick, now_ns)

    def _write(self) -> None:
        compressor, waiting, due_s = zstandard.ZstdCompressor(), bytearray(), 0.0
        with tempfile.TemporaryFile() as file:
            while True:
                messages, tick = self._queue.get()  # type: ignore[misc]  # what `record` puts
                waiting += b"".join([*(message.payload for message in messages), tick])
                if len(waiting) > CHUNK_BYTES or time.monotonic() > due_s:
                    file.write(compressor.compress(bytes(waiting)))
                    file.flush()
                    waiting.clear()
                    due_s = time.monotonic() + 0.5


def _weights(policy: Path) -> dict[str, np.ndarray]:
    import onnx
    from onnx import numpy_helper

    model = onnx.load_model_from_string(load_policy(policy).data)
    return {t.name: numpy_helper.to_array(t).astype(np.float64) for t in model.graph.initializer}


def _bare(port: int, rate_hz: float, seconds: float, fifo: int, policy: Path) -> None:
    """Tick, and print what each phase took."""
    with Bus(BusConfig(port=port), time.monotonic_ns) as bus:
        loop = BareLoop(bus, policy)
        time.sleep(1.0)
        realtime.prepare(fifo)
        gc.disable()
        phases: dict[str, list[int]] = {
            name: [] for name in ("lateness", "waking to command", "handing over the record")
        }
        begin_ns, count = time.monotonic_ns(), round(rate_hz * seconds)
        for index in range(count):
            due_ns = begin_ns + round(index * 1e9 / rate_hz)
            time.sleep(max(0, due_ns - time.monotonic_ns()) * 1e-9)
            woke_ns = time.monotonic_ns()
            command = loop.decide(index, woke_ns)
            loop.publish(command, woke_ns)
            sent_ns = time.monotonic_ns()
            loop.record(command, woke_ns)
            handed_ns = time.monotonic_ns()
            for name, ns in zip(
                phases, (woke_ns - due_ns, sent_ns - woke_ns, handed_ns - sent_ns), strict=True
            ):
                phases[name].append(ns)
    warm = round(WARM * count)
    print(json.dumps(_percentiles({name: ns[warm:] for name, ns in phases.items()})))


if __name__ == "__main__":
    main()
