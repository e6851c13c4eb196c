"""Decoders: each turns the sensor messages of one topic into retinas that fit the contract."""

import math
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import DecodeError

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.beams import Beams
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.topics import RETINA, SCAN, SENSORS, Topic
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    UndecodableError,
    UnfitError,
    check_encoding,
    unpack_stamp,
)
from reflexarc_runtime.sensing.distances import (
    beams_of_scan,
    check_tells_ranges,
    distances_of_values,
    fan_of_rays,
)
from reflexarc_runtime.sensing.retina import (
    Scan,
    UnusableScanError,
    check_scannable,
    retina_from_scan,
)

M = TypeVar("M", RawImage, LaserScan)

_QUOTED = 40
"""Characters of a sender's text that a reason quotes."""


@dataclass(frozen=True, slots=True)
class Sensed:
    """A sensor message that was decoded and fits the contract."""

    stamp: Stamp
    received_ns: int
    retina: Retina
    scan: Scan | None = None
    """The scan that the retina was made of, where a guard asks for it."""


class Sense(Protocol):
    """Turns the messages of one topic into retinas."""

    topic: Topic

    def beams(self, sensed: Sensed) -> Beams | None:
        """What a message tells of distances; None if nothing is left of it."""
        ...

    def decode(self, message: Message) -> Sensed:
        """Decode and check one message.

        Raises:
            UndecodableError: it cannot be decoded.
            UnfitError: it decodes, and does not fit the contract.
        """
        ...


class RetinaSense:
    """Reads retinas that are sent as such: `foxglove.RawImage`, width = rays, height = eyes."""

    topic = RETINA

    def __init__(self, spec: RetinaSpec) -> None:
        self._spec = spec
        self._fan, self._distances_m = fan_of_rays(spec), distances_of_values(spec.range_m)

    def beams(self, sensed: Sensed) -> Beams | None:
        """See `Sense.beams`: where each ray's thing is at most."""
        return Beams(self._fan, self._distances_m.take(sensed.retina[0, :, 0]))

    def decode(self, message: Message) -> Sensed:
        """See `Sense.decode`."""
        stamp, image = parse(message, RawImage)
        _check_image(image, self._spec)
        retina = np.frombuffer(image.data, np.uint8).reshape(self._spec.shape)
        return Sensed(stamp, message.received_ns, retina)


class ScanSense:
    """Makes retinas from scans: `foxglove.LaserScan`.

    Args:
        spec: the eye that they are made for.
        keeps_scans: whether what is sensed holds its scan as well, as a guard needs it.

    Raises:
        ContractError: the policy sees more than one eye or channel.
    """

    topic = SCAN

    def __init__(self, spec: RetinaSpec, *, keeps_scans: bool = False) -> None:
        check_scannable(spec)
        self._spec = spec
        self._keeps_scans = keeps_scans

    def beams(self, sensed: Sensed) -> Beams | None:
        """See `Sense.beams`: the raw beams."""
        return None if sensed.scan is None else beams_of_scan(sensed.scan)

    def decode(self, message: Message) -> Sensed:
        """See `Sense.decode`."""
        stamp, scan = parse(message, LaserScan)
        if not (math.isfinite(scan.start_angle) and math.isfinite(scan.end_angle)):
            raise UnfitError("scan: expected finite angles")
        try:
            sweep = Scan(scan.start_angle, scan.end_angle, np.array(scan.ranges, np.float64))
            retina = retina_from_scan(sweep, self._spec)
        except UnusableScanError as error:
            raise UnfitError(f"scan: {error}") from None
        return Sensed(stamp, message.received_ns, retina, sweep if self._keeps_scans else None)


def sense_for(kind: str, spec: RetinaSpec, *, guarded: bool = False) -> Sense:
    """The sense for the value of `--input`: retina or scan.

    Args:
        kind: which.
        spec: the eye of the policy.
        guarded: whether a guard will ask it for distances.

    Raises:
        UsageError: another value.
        ContractError: a scan cannot give the retina that the policy sees, or a guard shall read
            distances from retinas that tell none.
    """
    if kind not in SENSORS:
        raise UsageError(f"--input: expected {' or '.join(SENSORS)}, got {kind!r}")
    if kind == "scan":
        return ScanSense(spec, keeps_scans=guarded)
    if guarded:
        check_tells_ranges(spec)
    return RetinaSense(spec)


def parse(message: Message, kind: type[M]) -> tuple[Stamp, M]:
    """Decode stamp and payload.

    Raises:
        UndecodableError: wrong encoding, attachment, size, or bytes that are no such message.
    """
    check_encoding(message, kind.DESCRIPTOR.full_name)
    stamp = unpack_stamp(message.attachment)
    try:
        return stamp, kind.FromString(message.payload)
    except DecodeError:
        raise UndecodableError(f"payload: no {kind.DESCRIPTOR.full_name}") from None


def _check_image(image: RawImage, spec: RetinaSpec) -> None:
    expected = (spec.rays, spec.eyes, spec.encoding, spec.size)
    # The reason is in every tick until the next good input, so a text of 1 MiB must not be in it.
    got = (image.width, image.height, image.encoding[:_QUOTED], len(image.data))
    if got != expected:
        raise UnfitError(f"retina: expected (width, height, encoding, bytes) {expected}, got {got}")
