"""A lidar that speaks ROS 2 by a script: jitter, lost scans, a queue that fills and empties, death.

All times are seconds from the script's beginning. A scan's stamp is when it was taken; when it is
sent is what the phases differ in.
"""

import struct
import time
from dataclasses import dataclass

import numpy as np
import zenoh

from support.ros2 import Time, laser_scan

QUEUE_S = 2.0
"""How deep the queue is."""
JITTER = 0.1
"""Of a period, earlier or later."""
LOST = 10
"""Every so-manyth scan, where some are lost."""


@dataclass(frozen=True)
class Phase:
    """A part of the script, by when scans are taken, and when its ticks are looked at."""

    name: str
    begin_s: float
    end_s: float
    look_s: tuple[float, float]


PHASES = (
    Phase("settling", 0.0, 2.0, (0.0, 0.0)),
    Phase("jitter", 2.0, 5.0, (2.0, 5.0)),
    Phase("one in ten lost", 5.0, 10.0, (5.0, 10.0)),
    Phase("queue of 2 s", 10.0, 13.0, (12.5, 15.0)),  # the first one comes at 12 s
    Phase("the queue empties", 13.0, 15.0, (0.0, 0.0)),  # all at once
    Phase("behind it", 15.0, 18.0, (16.0, 18.0)),
)
DEATH_S = PHASES[-1].end_s


@dataclass(frozen=True)
class Sending:
    """One scan."""

    at_s: float
    taken_s: float


def script(rate_hz: float, seed: int = 0) -> list[Sending]:
    """All scans of a lidar, in the order in which they are sent."""
    rng, period_s = np.random.default_rng(seed), 1.0 / rate_hz
    sendings, emptied_s = [], PHASES[-1].begin_s
    for number in range(round(DEATH_S * rate_hz)):
        taken_s = number * period_s
        name = next(phase.name for phase in PHASES if taken_s < phase.end_s)
        at_s = taken_s + (1.0 + rng.uniform(-JITTER, JITTER)) * period_s  # a turn, and its jitter
        if name == "one in ten lost" and number % LOST == 0:
            continue
        if name == "queue of 2 s":
            at_s += QUEUE_S
        elif name == "the queue empties":
            at_s = max(at_s, emptied_s)
        sendings.append(Sending(at_s, taken_s))
    return sendings


def play(session: zenoh.Session, key: str, sendings: list[Sending]) -> tuple[int, int]:
    """Send them; returns when it began (monotonic clock) and when it died (wall clock), ns."""
    publisher = session.declare_publisher(key)
    begin_ns, wall_ns = time.monotonic_ns(), time.time_ns()
    for number, sending in enumerate(sendings):
        stamp_ns = wall_ns + round(sending.taken_s * 1e9)
        stamp = Time(*divmod(stamp_ns, 1_000_000_000))
        scan = laser_scan([float("inf")] * 181, stamp=stamp).serialize()
        attachment = struct.pack("<qqB16s", number, stamp_ns, 16, bytes(range(16)))
        time.sleep(max(0.0, sending.at_s - (time.monotonic_ns() - begin_ns) * 1e-9))
        publisher.put(scan, attachment=attachment)
    return begin_ns, time.time_ns()
