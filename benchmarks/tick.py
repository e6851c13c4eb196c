"""What does one tick of the loop cost, and how many bytes does it leave on disk?

    python benchmarks/tick.py [--ticks 4000] [--json]
    python benchmarks/in_turns.py ../before --rounds 9 -- tick.py

From waking to the end of the tick, records handed over: in a tight loop, where all is in the
caches, and with a pause of 2 ms before each tick, where little is. Guard and watchdog are on, as
`reflexarc run` has them; things are near, and what the policy wants is free. The bytes are those of
a log of the real recorder. Nothing is asserted.
"""

import argparse
import gc
import json
import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

import numpy as np

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.guard import Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.loop_watchdog import Budget, LoopWatchdog
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.pacer import Wakeup
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import sense_for
from support.policies import exported  # found by the line above
from support.recordings import (
    CONTRACT,
    PERIOD_NS,
    Nowhere,
    drive,
    nominal,
    retina_at,
    smooth_retinas,
)

PAUSE_S = 0.002
BUDGET = Budget(50_000_000, PERIOD_NS, 60.0)
FREE, NOTHING_FREE = 150, 250
"""Values of a ray of 5 m: something at 2 m, and at 0.1 m."""


class Stopwatch:
    """A pacer that gives one retina a tick at once, or after a pause, and times the ticks."""

    def __init__(self, retinas: np.ndarray, pause_s: float) -> None:
        self._schedule = {slot: [retina_at(slot, seen)] for slot, seen in enumerate(retinas, 1)}
        self._pause_s = pause_s
        self._slot = 0
        self._began_ns = 0
        self.ticks_ns: list[int] = []

    def wait(self, should_stop: object) -> Wakeup | None:
        """See `Pacer.wait`."""
        if self._began_ns:
            self.ticks_ns.append(time.perf_counter_ns() - self._began_ns)
        if self._pause_s:
            time.sleep(self._pause_s)
        self._began_ns = time.perf_counter_ns()
        self._slot += 1
        return self._wake(self._schedule[self._slot])

    def farewell(self) -> Wakeup:
        """See `Pacer.farewell`."""
        return self._wake([])

    def now_ns(self) -> int:
        """See `Pacer.now_ns`."""
        return time.monotonic_ns()

    def _wake(self, messages: object) -> Wakeup:
        now_ns = 5_000_000_000 + self._slot * PERIOD_NS
        return Wakeup(self._slot, now_ns, now_ns, now_ns, tuple(messages), 0)  # type: ignore[call-overload]


class Nothing:
    """A sink that takes all and keeps nothing."""

    state = "on"

    def put(self, message: object) -> None:
        """See `Sink.put`."""

    def put_tick(self, record: object) -> None:
        """See `Sink.put_tick`."""

    def put_keyframe(self, keyframe: object) -> None:
        """See `Sink.put_keyframe`."""


class Silence:
    """Whom a watchdog that is never late has to speak to."""

    def renew(self) -> None:
        """See `Presence.renew`."""

    withdraw = end_decision = renew

    def stand(self, now_ns: int) -> None:
        """See `Speaker.stand`."""

    def tell(self, since_ns: int, late_ns: int, now_ns: int) -> Message:
        """See `Speaker.tell`."""
        raise NotImplementedError


def main() -> None:
    """Measure and print."""
    arguments = _arguments()
    free = np.minimum(smooth_retinas(arguments.ticks), FREE)
    walled = np.full_like(free, NOTHING_FREE)
    figures = {
        "tick, tight loop, µs": _tick_us(free, 0.0),
        "tick, after a pause, µs": _tick_us(free, PAUSE_S),
        "tick, tight loop, nothing free, µs": _tick_us(walled, 0.0),
        **_bytes(arguments.ticks),
    }
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:<34}{value:>10.2f}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ticks", type=int, default=4000)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _tick_us(retinas: np.ndarray, pause_s: float) -> float:
    """Median time of a tick, microseconds."""
    policy = load_policy(exported(CONTRACT, 3, "Relu"))
    sense = sense_for("retina", policy.contract.retina, guarded=True)
    guard = Guard.for_contract(GuardSettings(footprint=Footprint(radius_m=0.2)), policy.contract)
    controller = Controller(policy, policy.contract, sense, policy.policy_hash, guard=guard)
    stopwatch, silence = Stopwatch(retinas, pause_s), Silence()
    outlets = Outlets(Nowhere(), Nowhere(), Nowhere())
    watching = LoopWatchdog(BUDGET, lambda: 0, Inbox(), silence, silence, silence.end_decision)
    gc.disable()
    with watching as watch:
        node = Node(controller, stopwatch, outlets, sink=Nothing(), watch=watch)  # type: ignore[arg-type]
        node.run(max_ticks=len(retinas))
    gc.enable()
    return statistics.median(stopwatch.ticks_ns) / 1e3


def _bytes(ticks: int) -> dict[str, float]:
    """Bytes a tick: of the file without its attachments, and of the tick messages themselves."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.mcap"
        drive(path, exported(CONTRACT, 3, "Relu"), nominal(ticks), ticks)
        log = read_log(path)
        attached = sum(len(data) for data in log.attachments.values())
        payload = sum(len(record.payload) for record in log.records("/robot0/tick"))
        return {
            "log, bytes a tick": (path.stat().st_size - attached) / ticks,
            "tick messages, bytes a tick": payload / ticks,
        }


if __name__ == "__main__":
    main()
