"""`sensor_msgs/LaserScan` of ROS 2, in CDR, as our own scans, and as `foxglove.LaserScan`.

`sensor_msgs/LaserScan` measures from `angle_min` in steps of `angle_increment`, of either sign;
ours go counter-clockwise. Its `angle_max` is not used: drivers disagree on whether it is the last
beam or one step further. Ranges, after the message's comments and REP 117: below `range_min` is too
near to be measured (−inf); from `range_max` on nothing was met (+inf); NaN, zero and less are
unknown (NaN). Where a driver means something else, flags say so.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.messages.codec import timestamp
from reflexarc_runtime.ros2.cdr import UnusableMessageError, read_cdr, stamp_ns
from reflexarc_runtime.ros2.mounts import BASE
from reflexarc_runtime.ros2.ros_types import LASER_SCAN
from reflexarc_runtime.sensing.mounting import CENTRED, Mount, Sector, mounted, pose_of, without
from reflexarc_runtime.sensing.range_meaning import RangeMeaning
from reflexarc_runtime.sensing.scan import MOST_BEAMS, Scan, UnusableScanError, check_turns

MAX_BEAMS = MOST_BEAMS
"""What the runtime would refuse need not be sent."""


@dataclass(frozen=True)
class RosScan:
    """A scan as the robot took it, with our order and our meaning of the ranges."""

    stamp_ns: int
    """The header's, on the robot's clock."""
    frame_id: str
    sweep: Scan
    """In the frame of the scanner."""
    mount: Mount = CENTRED
    """How the scanner sits on the robot."""


@dataclass(frozen=True)
class RosScanner:
    """What is known of a robot's scanner beside what its messages say."""

    meaning: RangeMeaning = field(default_factory=RangeMeaning)
    """What its driver means by its numbers."""
    mount: Mount | None = None
    """How it sits on the robot; None: as the robot says, else in its middle, looking ahead."""
    ignored: tuple[Sector, ...] = ()
    """Sectors in which it sees its own robot, as seen from the scanner, in the robot's axes."""


STANDARD = RosScanner()
"""A scanner after the standard, in the middle of its robot."""


def decode_scan(
    payload: bytes,
    scanner: RosScanner = STANDARD,
    mount_in: Callable[[str], Mount | None] = lambda frame: None,
) -> RosScan:
    """Read `sensor_msgs/LaserScan`.

    Args:
        payload: of the message.
        scanner: what is known of the scanner beside.
        mount_in: how a scanner of a frame sits; None if nobody said it.

    Raises:
        UnusableMessageError: not little-endian CDR, not a `LaserScan`, or not usable as a scan.
    """
    message = read_cdr(payload, LASER_SCAN)
    try:
        mount = scanner.mount or mount_in(message.header.frame_id) or CENTRED
        sweep = _sweep(message, scanner.meaning)
        check_turns(sweep)
        sweep = _own_parts_left_out(sweep, mount, scanner.ignored)
    except UnusableScanError as error:
        raise UnusableMessageError(str(error)) from None
    return RosScan(
        stamp_ns=stamp_ns(message.header),
        frame_id=message.header.frame_id,
        sweep=sweep,
        mount=mount,
    )


def encode_scan(scan: RosScan, base: str = BASE) -> bytes:
    """A scan as `foxglove.LaserScan`; intensities are left out, as no retina uses them.

    Its pose is the scanner's on the robot, so its frame is the robot's own: a viewer that knew the
    scanner's frame as well would move the scan twice.
    """
    message = LaserScan(
        timestamp=timestamp(scan.stamp_ns),
        frame_id=scan.frame_id if scan.mount == CENTRED else base,
        start_angle=scan.sweep.start_rad,
        end_angle=scan.sweep.end_rad,
        ranges=scan.sweep.ranges_m,
    )
    message.pose.CopyFrom(pose_of(scan.mount))
    return message.SerializeToString()


def _sweep(message: Any, meaning: RangeMeaning) -> Scan:
    """The beams in our order, by our standard.

    Raises:
        UnusableMessageError: angles, limits or the number of beams are not usable.
        UnusableScanError: limits that cannot be meant, or ranges beyond them.
    """
    start_rad, step_rad = map(meaning.radians, (message.angle_min, message.angle_increment))
    if not (math.isfinite(start_rad) and math.isfinite(step_rad)) or step_rad == 0.0:
        raise UnusableMessageError("angles that are none")
    count = len(message.ranges)
    if not 2 <= count <= MAX_BEAMS:
        raise UnusableMessageError(f"fewer than 2 or more than {MAX_BEAMS} beams")
    last_rad = start_rad + (count - 1) * step_rad
    with np.errstate(invalid="ignore"):  # a signalling NaN is an unknown beam, too
        ranges_m = message.ranges.astype(np.float64)
    ranges_m = meaning.read(ranges_m, float(message.range_min), float(message.range_max))
    if step_rad < 0.0:
        return Scan(last_rad, start_rad, ranges_m[::-1])
    return Scan(start_rad, last_rad, ranges_m)


def _own_parts_left_out(scan: Scan, mount: Mount, ignored: tuple[Sector, ...]) -> Scan:
    """The scan, still in the scanner's frame, without what it sees of its own robot."""
    if not ignored:
        return scan
    ranges_m = without(mounted(scan, mount), ignored).ranges_m
    return replace(scan, ranges_m=ranges_m[::-1] if mount.upside_down else ranges_m)
