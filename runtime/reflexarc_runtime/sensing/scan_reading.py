"""From a scan as it came to one in the robot's frame, by the standard of ranges."""

import math

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.sensing.mounting import CENTRED, mount_of, mounted, without
from reflexarc_runtime.sensing.scan import MOST_BEAMS, Scan, UnusableScanError
from reflexarc_runtime.sensing.sense_settings import SenseSettings


def read_scan(scan: LaserScan, settings: SenseSettings) -> Scan:
    """A scan in the robot's frame: turned as its scanner sits, and read as its driver means it.

    Raises:
        UnusableScanError: angles or a pose that are none, or ranges that contradict the settings.
    """
    if not (math.isfinite(scan.start_angle) and math.isfinite(scan.end_angle)):
        raise UnusableScanError("expected finite angles")
    if len(scan.ranges) > MOST_BEAMS:
        raise UnusableScanError(f"{len(scan.ranges)} beams, at most {MOST_BEAMS} may be")
    meaning = settings.meaning
    start_rad, end_rad = meaning.radians(scan.start_angle), meaning.radians(scan.end_angle)
    own = Scan(start_rad, end_rad, meaning.read(np.array(scan.ranges, np.float64)))
    mount = settings.mount
    if mount is None:
        mount = mount_of(scan.pose) if scan.HasField("pose") else CENTRED
    read = without(mounted(own, mount), settings.ignored)
    if settings.least_returns is not None:
        _check_returns(read, settings.least_returns)
    return read


def _check_returns(scan: Scan, least: float) -> None:
    """Refuse a scan with hardly any return: of a scanner that is covered or broken."""
    ranges_m = scan.ranges_m
    returns, beams = int(np.count_nonzero(np.isfinite(ranges_m) & (ranges_m > 0.0))), len(ranges_m)
    if returns < least * beams:
        raise UnusableScanError(
            f"{returns} of {beams} beams have a return, a share below {least:g} "
            "(--least-returns): is the scanner covered, or broken?"
        )
