"""Decoders: each turns the sensor messages of one topic into retinas that fit the contract."""

import math
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import DecodeError

from reflexarc_runtime.arrays import Retina
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


class Sense(Protocol):
    """Turns the messages of one topic into retinas."""

    topic: Topic

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

    def decode(self, message: Message) -> Sensed:
        """See `Sense.decode`."""
        stamp, image = parse(message, RawImage)
        _check_image(image, self._spec)
        retina = np.frombuffer(image.data, np.uint8).reshape(self._spec.shape)
        return Sensed(stamp, message.received_ns, retina)


class ScanSense:
    """Makes retinas from scans: `foxglove.LaserScan`.

    Raises:
        ContractError: the policy sees more than one eye or channel.
    """

    topic = SCAN

    def __init__(self, spec: RetinaSpec) -> None:
        check_scannable(spec)
        self._spec = spec

    def decode(self, message: Message) -> Sensed:
        """See `Sense.decode`."""
        stamp, scan = parse(message, LaserScan)
        if not (math.isfinite(scan.start_angle) and math.isfinite(scan.end_angle)):
            raise UnfitError("scan: expected finite angles")
        try:
            sweep = Scan(scan.start_angle, scan.end_angle, np.array(scan.ranges, np.float64))
            return Sensed(stamp, message.received_ns, retina_from_scan(sweep, self._spec))
        except UnusableScanError as error:
            raise UnfitError(f"scan: {error}") from None


def sense_for(kind: str, spec: RetinaSpec) -> Sense:
    """The sense for the value of `--input`: retina or scan.

    Raises:
        UsageError: another value.
        ContractError: a scan cannot give the retina that the policy sees.
    """
    if kind not in SENSORS:
        raise UsageError(f"--input: expected {' or '.join(SENSORS)}, got {kind!r}")
    return RetinaSense(spec) if kind == "retina" else ScanSense(spec)


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
