"""WebP: the chunks of a RIFF file (RFC 9649, section 2)."""

import struct
from collections.abc import Iterator

from reflexarc_sim_bridge.body.camera.formats.exif import orientation_of
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError


def facts_of_webp(data: bytes) -> Facts:
    """What a WebP tells.

    Raises:
        UnreadableImageError: it is cut, or an animation.
    """
    chunks = list(_chunks(data))
    images = sum(name == b"ANMF" for name, _ in chunks)
    if images > 1:
        raise UnreadableImageError(f"is an animation of {images} images; save one a file")
    exif = next((body for name, body in chunks if name == b"EXIF"), None)
    return Facts(1 if exif is None else orientation_of(exif))


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = 12
    while place + 8 <= len(data):
        name, length = struct.unpack_from("<4sI", data, place)
        if place + 8 + length > len(data):
            raise UnreadableImageError("is cut")
        yield name, data[place + 8 : place + 8 + length]
        place += 8 + length + length % 2
