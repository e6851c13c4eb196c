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
from reflexarc_runtime.contract.eye_in_words import differences, eye_in_words, is_an_eye
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
from reflexarc_runtime.sensing.retina import check_scannable, retina_from_scan
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError
from reflexarc_runtime.sensing.scan_reading import read_scan
from reflexarc_runtime.sensing.scans_of_before import retina_of_before
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.stillness import picture_of

M = TypeVar("M", RawImage, LaserScan)

DEFAULT = SenseSettings()
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
    picture: bytes = b""
    """By which it is known again, where frozen pictures count."""


class Sense(Protocol):
    """Turns the messages of one topic into retinas."""

    topic: Topic
    settings: SenseSettings | None
    """How it reads what comes; None: as before version 4 of the rules."""

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
    """Reads retinas that are sent as such: `foxglove.RawImage`, width = rays, height = eyes.

    Args:
        spec: the eye that they must be of.
        settings: how to read them; None: as before version 4 of the rules, when no retina said
            which eye made it.
    """

    topic = RETINA

    def __init__(self, spec: RetinaSpec, settings: SenseSettings | None = DEFAULT) -> None:
        self._spec, self.settings = spec, settings
        self._words = eye_in_words(spec)
        self._knows_again = settings is not None and settings.frozen_after_s is not None
        self._fan, self._distances_m = fan_of_rays(spec), distances_of_values(spec.range_m)

    def beams(self, sensed: Sensed) -> Beams | None:
        """See `Sense.beams`: where each ray's thing is at most."""
        return Beams(self._fan, self._distances_m.take(sensed.retina[0, :, 0]))

    def decode(self, message: Message) -> Sensed:
        """See `Sense.decode`."""
        stamp, image = parse(message, RawImage)
        _check_image(image, self._spec)
        if self.settings is not None and image.frame_id != self._words:
            _check_eye(image.frame_id, self._spec, self.settings)
        retina = np.frombuffer(image.data, np.uint8).reshape(self._spec.shape)
        if not self._knows_again:
            return Sensed(stamp, message.received_ns, retina)
        return Sensed(stamp, message.received_ns, retina, None, picture_of(image.data))


class ScanSense:
    """Makes retinas from scans: `foxglove.LaserScan`.

    Args:
        spec: the eye that they are made for.
        settings: how to read them; None: as before version 4 of the rules, when neither the pose
            of the scanner nor what lies too near was looked at.
        keeps_scans: whether what is sensed holds its scan as well, as a guard needs it.

    Raises:
        ContractError: the policy sees more than one eye or channel.
    """

    topic = SCAN

    def __init__(
        self,
        spec: RetinaSpec,
        settings: SenseSettings | None = DEFAULT,
        *,
        keeps_scans: bool = False,
    ) -> None:
        check_scannable(spec)
        self._spec, self.settings = spec, settings
        self._keeps_scans = keeps_scans
        self._knows_again = settings is not None and settings.frozen_after_s is not None

    def beams(self, sensed: Sensed) -> Beams | None:
        """See `Sense.beams`: the raw beams."""
        return None if sensed.scan is None else beams_of_scan(sensed.scan)

    def decode(self, message: Message) -> Sensed:
        """See `Sense.decode`."""
        stamp, scan = parse(message, LaserScan)
        try:
            sweep, retina = self._read(scan)
        except UnusableScanError as error:
            raise UnfitError(f"scan: {error}") from None
        kept = sweep if self._keeps_scans else None
        if not self._knows_again:
            return Sensed(stamp, message.received_ns, retina, kept)
        picture = picture_of(np.array(scan.ranges, np.float64).tobytes())
        return Sensed(stamp, message.received_ns, retina, kept, picture)

    def _read(self, scan: LaserScan) -> tuple[Scan, Retina]:
        """The scan in the robot's frame and by the standard, and its retina."""
        if self.settings is not None:
            sweep = read_scan(scan, self.settings)
            return sweep, retina_from_scan(sweep, self._spec)
        if not (math.isfinite(scan.start_angle) and math.isfinite(scan.end_angle)):
            raise UnusableScanError("expected finite angles")
        sweep = Scan(scan.start_angle, scan.end_angle, np.array(scan.ranges, np.float64))
        return sweep, retina_of_before(sweep, self._spec)


def sense_for(
    kind: str,
    spec: RetinaSpec,
    settings: SenseSettings | None = DEFAULT,
    *,
    guarded: bool = False,
) -> Sense:
    """The sense for the value of `--input`: retina or scan.

    Args:
        kind: which.
        spec: the eye of the policy.
        settings: how to read what comes; None: as before version 4 of the rules.
        guarded: whether a guard will ask it for distances.

    Raises:
        UsageError: another value.
        ContractError: a scan cannot give the retina that the policy sees, or a guard shall read
            distances from retinas that tell none.
    """
    if kind not in SENSORS:
        raise UsageError(f"--input: expected {' or '.join(SENSORS)}, got {kind!r}")
    if kind == "scan":
        return ScanSense(spec, settings, keeps_scans=guarded)
    if guarded:
        check_tells_ranges(spec)
    return RetinaSense(spec, settings)


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


def _check_eye(words: str, spec: RetinaSpec, settings: SenseSettings) -> None:
    if is_an_eye(words):
        wrong = differences(words, spec)
        if wrong:
            raise UnfitError(f"retina of another eye: {', '.join(wrong)}")
    elif not settings.allow_unstated_eye:
        raise UnfitError(
            "retina that does not say which eye made it; its frame_id should be "
            f"{eye_in_words(spec)!r} (--allow-unstated-eye to take it as it is)"
        )
