"""The attachments of an MCAP file: where they are, and their bytes when somebody asks for them."""

import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from reflexarc_logs.container.frames import CRC_BYTES, DamagedError, Frame, blocks
from reflexarc_runtime.errors import LogError

MAX_ATTACHMENT_BYTES = 96 << 20
"""The largest attachment that is read into memory; others can only be copied, by `recover`."""
MAX_NAME_BYTES = 4096

_TIMES_BYTES = 16


@dataclass(frozen=True, slots=True)
class Attached:
    """An attachment in a file."""

    name: str
    media_type: str
    log_ns: int
    created_ns: int
    data: int
    """Offset of its bytes."""
    size: int
    """How many they are."""
    crc: int
    """0: it has none."""

    @property
    def end(self) -> int:
        """Offset behind its CRC, its last field."""
        return self.data + self.size + CRC_BYTES


MOST_OF_A_NAME = 64
"""Attachments of one name that are told apart; a log has one for each robot that was merged."""


def nth_name(name: str, number: int) -> str:
    """What the second, third … attachment of a name is called here."""
    return name if number == 1 else f"{name}#{number}"


class Attachments(Mapping[str, bytes]):
    """Name → bytes, which are read anew each time. The second of a name is `NAME#2`."""

    def __init__(self, path: Path, places: Mapping[str, Attached]) -> None:
        self._path = path
        self._places = places

    def __getitem__(self, name: str) -> bytes:
        place = self._places[name]
        if place.size > MAX_ATTACHMENT_BYTES:
            raise LogError(
                f"{self._path}: {name[:40]} of {place.size >> 20} MiB is attached, at most "
                f"{MAX_ATTACHMENT_BYTES >> 20} MiB are read here"
            )
        with self._path.open("rb") as file:
            file.seek(place.data)
            return file.read(place.size)

    def __iter__(self) -> Iterator[str]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


def attached_at(file: BinaryIO, frame: Frame) -> Attached:
    """Where the parts of an attachment are; moves the position of the file.

    Raises:
        DamagedError: its fields do not fit into it.
    """
    file.seek(frame.body)
    try:
        log_ns, created_ns = struct.unpack("<QQ", file.read(_TIMES_BYTES))
        name, media_type = _text(file), _text(file)
        (size,) = struct.unpack("<Q", file.read(8))
        data = file.tell()
        if data + size + CRC_BYTES > frame.end:
            raise DamagedError("an attachment: it is longer than its record")
        file.seek(data + size)
        (crc,) = struct.unpack("<I", file.read(CRC_BYTES))
    except (struct.error, UnicodeDecodeError):
        raise DamagedError("an attachment: its fields are cut off") from None
    return Attached(name, media_type, log_ns, created_ns, data, size, crc)


def is_intact(file: BinaryIO, frame: Frame, attached: Attached) -> bool:
    """Whether the CRC of an attachment fits; without one, there is nothing to tell by."""
    crc = 0
    for block in blocks(file, frame.body, attached.data + attached.size):
        crc = zlib.crc32(block, crc)
    return attached.crc in (0, crc)


def _text(file: BinaryIO) -> str:
    (size,) = struct.unpack("<I", file.read(4))
    if size > MAX_NAME_BYTES:
        raise DamagedError("an attachment: its name has no end")
    return file.read(size).decode()
