"""Directories of TIFF, which Exif uses in every kind of file (TIFF 6.0, section 2)."""

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from reflexarc_sim_bridge.body.camera.formats.facts import UnreadableImageError

ORIENTATION = 274

_FORMATS = {1: "B", 3: "H", 4: "I"}
"""Struct formats of the types byte, short and long; no other type is asked for here."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One tag of a directory."""

    offset: int
    """Where its first value lies."""
    value: int
    """Its first value; of an unknown type, 0."""


@dataclass(frozen=True, slots=True)
class Directory:
    """One directory: the tags of one image."""

    entries: dict[int, Entry]

    def value(self, tag: int, otherwise: int) -> int:
        """The first value of a tag."""
        entry = self.entries.get(tag)
        return otherwise if entry is None else entry.value


def orientation_of(exif: bytes) -> int:
    """The orientation that a block of Exif names; 1 where it names none, or is broken."""
    try:
        first = next(directories(exif.removeprefix(b"Exif\0\0")), Directory({}))
    except UnreadableImageError:
        return 1
    return valid_orientation(first.value(ORIENTATION, 1))


def valid_orientation(value: int) -> int:
    """Any other number than 1 to 8 is taken as upright, as viewers do."""
    return value if 1 <= value <= 8 else 1


def order_of(data: bytes) -> str:
    """Struct's sign of the byte order of a TIFF."""
    return "<" if data[:2] == b"II" else ">"


def directories(data: bytes) -> Iterator[Directory]:
    """All directories, in their chain.

    Raises:
        UnreadableImageError: the chain leads out of the data, or into itself.
    """
    order, seen = order_of(data), set[int]()
    try:
        (at,) = struct.unpack_from(order + "I", data, 4)
        while at:
            if at in seen:
                raise UnreadableImageError("has directories in a circle")
            seen.add(at)
            directory, at = _directory(data, order, at)
            yield directory
    except struct.error:
        raise UnreadableImageError("is cut") from None


def _directory(data: bytes, order: str, at: int) -> tuple[Directory, int]:
    """The directory at an offset, and the offset of the next one."""
    (count,) = struct.unpack_from(order + "H", data, at)
    entries: dict[int, Entry] = {}
    for place in range(at + 2, at + 2 + 12 * count, 12):
        tag, kind, values = struct.unpack_from(order + "HHI", data, place)
        entries[tag] = _entry(data, order, place + 8, kind, values)
    (following,) = struct.unpack_from(order + "I", data, at + 2 + 12 * count)
    return Directory(entries), following


def _entry(data: bytes, order: str, place: int, kind: int, values: int) -> Entry:
    form = _FORMATS.get(kind)
    if form is None:
        return Entry(place, 0)
    if values * struct.calcsize(form) > 4:  # too long for the entry: it holds where they lie
        (place,) = struct.unpack_from(order + "I", data, place)
    (value,) = struct.unpack_from(order + form, data, place)
    return Entry(place, value)
