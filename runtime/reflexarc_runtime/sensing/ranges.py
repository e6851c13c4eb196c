"""Ranges for a guard from a topic of their own: `foxglove.LaserScan`, beside what a policy sees.

A lidar, a ring of ultrasonic sensors, or a bumper: a scan whose pressed sectors measure 0 and whose
others measure +inf.
"""

from dataclasses import dataclass

from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.messages.wire import Message, Stamp, UnfitError
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError, check_sweep
from reflexarc_runtime.sensing.scan_reading import read_scan
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import parse


@dataclass(frozen=True, slots=True)
class Ranged:
    """A scan that a guard looks at, and when it came."""

    stamp: Stamp
    received_ns: int
    scan: Scan


def decode_ranges(message: Message, settings: SenseSettings) -> Ranged:
    """Decode and check one message.

    Args:
        message: from the topic of the ranges.
        settings: what the scanner's driver means, and how it sits.

    Raises:
        UndecodableError: it cannot be decoded.
        UnfitError: it decodes, and its beams lead nowhere.
    """
    stamp, scan = parse(message, LaserScan)
    try:
        sweep = read_scan(scan, settings)
        check_sweep(sweep)
    except UnusableScanError as error:
        raise UnfitError(f"ranges: {error}") from None
    return Ranged(stamp, message.received_ns, sweep)
