"""WebP: the chunks of a RIFF file (RFC 9649, section 2)."""

import math
import struct
from collections.abc import Iterator

from reflexarc_sim_bridge.body.camera.formats.exif import orientation_of
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

_SIZED = (b"VP8X", b"VP8L", b"VP8 ")
_LARGEST = (1 << 14) - 1
"""Most columns and rows of an image that is not put together of several: 14 bits."""


def facts_of_webp(data: bytes) -> Facts:
    """What a WebP tells.

    Raises:
        UnreadableImageError: it is cut, or an animation.
    """
    chunks = list(_chunks(data))
    images = sum(name == b"ANMF" for name, _ in chunks)
    if images > 1:
        raise UnreadableImageError(f"is an animation of {images} images; save one a file")
    sizes = [_size(name, body) for name, body in chunks if name in _SIZED]
    width, height = max(sizes, key=math.prod, default=(0, 0))
    exif = next((body for name, body in chunks if name == b"EXIF"), None)
    orientation = 1 if exif is None else orientation_of(exif)
    return Facts(orientation, width=width, height=height)


def _size(name: bytes, body: bytes) -> tuple[int, int]:
    """Columns and rows, by one of the chunks that say them."""
    if len(body) < 10:
        raise UnreadableImageError("is cut")
    if name == b"VP8X":
        return int.from_bytes(body[4:7], "little") + 1, int.from_bytes(body[7:10], "little") + 1
    if name == b"VP8L":
        bits = int.from_bytes(body[1:5], "little")
        return (bits & _LARGEST) + 1, (bits >> 14 & _LARGEST) + 1
    width, height = struct.unpack_from("<HH", body, 6)
    return width & _LARGEST, height & _LARGEST


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = 12
    while place + 8 <= len(data):
        name, length = struct.unpack_from("<4sI", data, place)
        if place + 8 + length > len(data):
            raise UnreadableImageError("is cut")
        yield name, data[place + 8 : place + 8 + length]
        place += 8 + length + length % 2
