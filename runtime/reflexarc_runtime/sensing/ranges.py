"""Ranges for a guard from a topic of their own: `foxglove.LaserScan`, beside what a policy sees.

A lidar, a ring of ultrasonic sensors, or a bumper: a scan whose pressed sectors measure 0 and whose
others measure +inf.
"""

import math
from dataclasses import dataclass

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.messages.wire import Message, Stamp, UnfitError
from reflexarc_runtime.sensing.retina import MIN_STEP_RAD, Scan
from reflexarc_runtime.sensing.senses import parse


@dataclass(frozen=True, slots=True)
class Ranged:
    """A scan that a guard looks at, and when it came."""

    stamp: Stamp
    received_ns: int
    scan: Scan


def decode_ranges(message: Message) -> Ranged:
    """Decode and check one message.

    Raises:
        UndecodableError: it cannot be decoded.
        UnfitError: it decodes, and its beams lead nowhere.
    """
    stamp, scan = parse(message, LaserScan)
    first_rad, last_rad, count = scan.start_angle, scan.end_angle, len(scan.ranges)
    span_rad = last_rad - first_rad
    fits = count >= 2 and math.isfinite(first_rad) and math.isfinite(span_rad)
    step_rad = span_rad / (count - 1) if fits else 0.0
    # Half a step more than a circle: some drivers measure the first direction twice.
    if not (MIN_STEP_RAD <= step_rad <= math.pi and span_rad < 2.0 * math.pi + 0.5 * step_rad):
        raise UnfitError(f"ranges: {count} beams from {first_rad:g} to {last_rad:g} rad")
    ranges_m = np.array(scan.ranges, np.float64)
    return Ranged(stamp, message.received_ns, Scan(first_rad, last_rad, ranges_m))
