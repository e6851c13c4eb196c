"""PNG: its chunks, each with a checksum (W3C, Portable Network Graphics, third edition)."""

import struct
import zlib
from collections.abc import Iterator

from reflexarc_sim_bridge.body.camera.formats.exif import orientation_of
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

SIGNATURE = b"\x89PNG\r\n\x1a\n"


def facts_of_png(data: bytes) -> Facts:
    """What a PNG tells.

    Raises:
        UnreadableImageError: it is cut or damaged, or an animation.
    """
    orientation, transparent, width, height = 1, False, 0, 0
    for name, body in _chunks(data):
        if name == b"acTL" and (images := int.from_bytes(body[:4], "big")) > 1:
            raise UnreadableImageError(f"is an animation of {images} images; save one a file")
        if name == b"IHDR" and len(body) >= 8:
            width, height = struct.unpack_from(">II", body)
        if name == b"eXIf":
            orientation = orientation_of(body)
        transparent = transparent or name == b"tRNS"
    return Facts(orientation, transparent=transparent, width=width, height=height)


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    """Names and bodies up to the end's chunk. libpng would tell standard error of a flaw."""
    place = len(SIGNATURE)
    while True:
        head, body_at = data[place : place + 8], place + 8
        if len(head) < 8:
            raise UnreadableImageError("is cut")
        length, name = struct.unpack(">I4s", head)
        end = body_at + length
        body, check = data[body_at:end], data[end : end + 4]
        if len(check) < 4:
            raise UnreadableImageError("is cut")
        if zlib.crc32(name + body).to_bytes(4, "big") != check:
            raise UnreadableImageError("is damaged: a checksum differs")
        yield name, body
        if name == b"IEND":
            return
        place = end + 4
