"""A recorder beside a loop of 1 kHz, 5,000 messages a second: what does it cost to sync?

    python benchmarks/recorder.py [--seconds 5] [--rounds 3] [--folder .]

In turns, round by round: no recorder, one that is synced only at its end, every ten seconds, every
second, with every flush. Lateness is the loop's own, from deadline to wake-up. Syncs are counted
and timed at the system call.
"""

import argparse
import os
import statistics
import tempfile
import time
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.loop import realtime
from reflexarc_runtime.loop.sink import NoSink, Sink
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import RETINA
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding

RATE_HZ = 1000
A_TICK = 5
SPEC = RetinaSpec()
WAYS: dict[str, float | None] = {
    "no recorder": None,
    "at the end": 1e6,
    "every 10 s": 10.0,
    "every second": 1.0,
    "every flush": 0.0,
}


@dataclass
class Measured:
    """What one way showed, over all rounds."""

    lateness_us: list[float] = field(default_factory=list)
    syncs_ms: list[float] = field(default_factory=list)
    dropped: int = 0
    messages: int = 0
    log_bytes: int = 0
    cpu_s: float = 0.0


def timed(fsync: Callable[[int], None], syncs_ms: list[float]) -> Callable[[int], None]:
    """The same, timed."""

    def sync(descriptor: int) -> None:
        begin_s = time.perf_counter()
        fsync(descriptor)
        syncs_ms.append((time.perf_counter() - begin_s) * 1e3)

    return sync


def drive(sink: Sink, seconds: float, measured: Measured) -> None:
    """Put so many messages at each tick."""
    rng = np.random.default_rng(0)
    key, encoding = RETINA.key("robot0"), protobuf_encoding(RETINA.schema)
    payloads = [
        encode_retina(rng.integers(0, 256, SPEC.shape, dtype=np.uint8), SPEC, 0) for _ in range(64)
    ]
    begin_ns = time.monotonic_ns() + 10_000_000
    for tick in range(round(seconds * RATE_HZ)):
        deadline_ns = begin_ns + tick * 1_000_000_000 // RATE_HZ
        time.sleep(max(0, deadline_ns - time.monotonic_ns()) * 1e-9)
        now_ns = time.monotonic_ns()
        measured.lateness_us.append((now_ns - deadline_ns) * 1e-3)
        for i in range(A_TICK):
            number = tick * A_TICK + i
            stamp = pack_stamp(Stamp(number, now_ns))
            sink.put(Message(key, payloads[number % 64], encoding, stamp, now_ns))
    measured.messages += round(seconds * RATE_HZ) * A_TICK


def measure(sync_s: float | None, folder: Path, seconds: float, measured: Measured) -> None:
    """One round of one way."""
    path, fsync = folder / "log.mcap", os.fsync
    os.fsync = timed(fsync, measured.syncs_ms)
    cpu_s = time.process_time()
    try:
        recorder = None
        if sync_s is not None:
            run, keeping = RunInfo(run_id="b" * 32), Keeping(sync_s=sync_s)
            recorder = Recorder(path, run, b"", {}, wall_offset_ns=0, keeping=keeping)
        with recorder or nullcontext():
            drive(recorder or NoSink(), seconds, measured)
    finally:
        os.fsync = fsync
    measured.cpu_s += time.process_time() - cpu_s
    if recorder is not None:
        measured.dropped += recorder.dropped
        measured.log_bytes += path.stat().st_size
        path.unlink()


def line(name: str, measured: Measured) -> str:
    """One row of the table."""
    late = sorted(measured.lateness_us)
    p50, p99 = (late[int(share * (len(late) - 1))] for share in (0.5, 0.99))
    syncs = measured.syncs_ms
    sync = f"{statistics.median(syncs):5.1f} {max(syncs):7.1f}" if syncs else "    -       -"
    return (
        f"{name:13} lateness p50 {p50:5.0f} µs p99 {p99:6.0f} µs  syncs {len(syncs):4} of {sync} ms"
        f"  {measured.cpu_s / measured.messages * 1e6:4.0f} µs of CPU a message"
        f"  {measured.dropped} of {measured.messages} dropped"
        f"  {measured.log_bytes / 1e6 / max(1, measured.messages) * 1e6:4.0f} bytes a message"
    )


def main() -> None:
    """Measure in turns, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--folder", type=Path, default=Path())
    flags = parser.parse_args()
    realtime.prepare(0)
    found = {name: Measured() for name in WAYS}
    with tempfile.TemporaryDirectory(dir=flags.folder) as folder:
        for _ in range(flags.rounds):
            for name, sync_s in WAYS.items():
                measure(sync_s, Path(folder), flags.seconds, found[name])
    for name, measured in found.items():
        print(line(name, measured))


if __name__ == "__main__":
    main()
