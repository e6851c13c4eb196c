"""Does the recorder keep up with 5,000 messages a second beside a loop of 1 kHz?

    python benchmarks/recorder.py [--seconds 20] [--rate 5000]

A loop of 1 kHz hands over its share of the messages at every tick, as a sink gets them. How late
its ticks were, with the recorder and without one, and what was dropped. Nothing is asserted.
"""

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

import numpy as np

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime.messages.wire import Message
from support.policies import exported
from support.recordings import CONTRACT, RUN, WALL_OFFSET_NS, retina_at, smooth_retinas

LOOP_HZ = 1000


def main() -> None:
    """Loop without a recorder and with one, print."""
    arguments = _arguments()
    each = arguments.rate // LOOP_HZ
    count = arguments.seconds * LOOP_HZ * each
    messages = [retina_at(k, seen) for k, seen in enumerate(smooth_retinas(count), 1)]
    _show("without", _loop(messages, each, lambda message: None))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        with Recorder(path, RUN, exported(CONTRACT), {}, wall_offset_ns=WALL_OFFSET_NS) as recorder:
            late_ms = _loop(messages, each, recorder.put)
        _show("with", late_ms)
        recorded = sum(len(table) for table in read_log(path).tables())
        size = path.stat().st_size / count
    print(
        f"{count} messages, {recorded} recorded, {recorder.dropped} dropped, {size:.0f} bytes each"
    )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--rate", type=int, default=5000)
    return parser.parse_args()


def _loop(messages: list[Message], each: int, put: Callable[[Message], None]) -> np.ndarray:
    """How late each tick was, ms, (ticks,)."""
    late_ms, begin_ns = [], time.monotonic_ns()
    for tick, first in enumerate(range(0, len(messages), each)):
        due_ns = begin_ns + tick * (1_000_000_000 // LOOP_HZ)
        time.sleep(max(0, due_ns - time.monotonic_ns()) / 1e9)
        late_ms.append((time.monotonic_ns() - due_ns) / 1e6)
        for message in messages[first : first + each]:
            put(message)
    return np.array(late_ms)


def _show(name: str, late_ms: np.ndarray) -> None:
    p50, p99, most = (*np.percentile(late_ms, [50, 99]), late_ms.max())
    print(f"{name:<9}a recorder: late by {p50:.2f} ms (median), {p99:.2f} (p99), {most:.2f} (most)")


if __name__ == "__main__":
    main()
