"""JPEG: its segments, up to the mark of its end (ITU-T T.81, annex B)."""

import struct
from collections.abc import Iterator

from reflexarc_sim_bridge.body.camera.formats.exif import orientation_of
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

SIGNATURE = b"\xff\xd8\xff"

_END, _EXIF = 0xD9, 0xE1
_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Marks of the segments that say size and channels: SOF0 to SOF15."""
_ALONE = frozenset((0x01, *range(0xD0, 0xD8)))
"""Marks without a segment: TEM, and RST0 to RST7 within a scan."""


def facts_of_jpeg(data: bytes) -> Facts:
    """What a JPEG tells.

    Raises:
        UnreadableImageError: its end is missing (OpenCV fills with grey), or it is CMYK.
    """
    orientation, width, height = 1, 0, 0
    for mark, body in _segments(data):
        if mark in _FRAMES and body[5:6] == b"\x04":  # inverted or not: no two programs agree
            raise UnreadableImageError("has the colours of a printer (CMYK); save it as RGB")
        if mark in _FRAMES and len(body) >= 5:
            height, width = struct.unpack_from(">HH", body, 1)
        if mark == _EXIF and body.startswith(b"Exif\0\0"):
            orientation = orientation_of(body)
    return Facts(orientation, width=width, height=height)


def _segments(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Marks and bodies, up to the end's mark."""
    place = 2
    while True:
        place = data.find(b"\xff", place) + 1
        if place == 0 or place >= len(data):
            raise UnreadableImageError("is cut")
        mark = data[place]
        if mark == _END:
            return
        if mark in (0x00, 0xFF) or mark in _ALONE:  # data of a scan, or a filling byte
            place += mark != 0xFF
            continue
        length = int.from_bytes(data[place + 1 : place + 3], "big")
        yield mark, data[place + 3 : place + 1 + length]
        place += 1 + length
