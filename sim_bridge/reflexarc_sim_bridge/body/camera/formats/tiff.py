"""TIFF: which of its many forms OpenCV shows truly (TIFF 6.0)."""

import struct

from reflexarc_sim_bridge.body.camera.formats.exif import (
    ORIENTATION,
    Directory,
    directories,
    order_of,
    valid_orientation,
)
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

_WIDTH, _HEIGHT = 256, 257
_SUBFILE, _BITS, _PHOTOMETRIC, _SAMPLE_FORMAT = 254, 258, 262, 339
_WHITE_IS_ZERO, _SEPARATED = 0, 5
_UNSIGNED, _FLOAT = 1, 3
_FULL_16 = 65535


def facts_of_tiff(data: bytes) -> Facts:
    """What a TIFF tells.

    Raises:
        UnreadableImageError: it holds several images, or one that OpenCV shows wrongly.
    """
    if data[2:4] in (b"+\0", b"\0+"):
        raise UnreadableImageError("is a BigTIFF; save it as a plain one")
    pages = [page for page in directories(data) if not page.value(_SUBFILE, 0) & 1]  # no previews
    if len(pages) != 1:
        raise UnreadableImageError(f"holds {len(pages)} images; save one a file")
    bits = pages[0].value(_BITS, 1)
    _check(pages[0], bits)
    # OpenCV widens packed 10, 12 and 14 bits to all of 16.
    white = _FULL_16 if bits in (10, 12, 14) else None
    width, height = (pages[0].value(tag, 0) for tag in (_WIDTH, _HEIGHT))
    orientation = valid_orientation(pages[0].value(ORIENTATION, 1))
    return Facts(orientation, white, width=width, height=height)


def upright(data: bytes) -> bytes:
    """The same file with an orientation of 1: OpenCV turns some TIFFs, and fails at others."""
    patched = bytearray(data)
    for page in directories(data):
        entry = page.entries.get(ORIENTATION)
        if entry is not None:
            if entry.offset + 2 > len(patched):
                raise UnreadableImageError("is cut")
            struct.pack_into(order_of(data) + "H", patched, entry.offset, 1)
    return bytes(patched)


def _check(page: Directory, bits: int) -> None:
    form, photometric = page.value(_SAMPLE_FORMAT, _UNSIGNED), page.value(_PHOTOMETRIC, 1)
    if form == _FLOAT:
        raise UnreadableImageError("has floating point, where no value is white; save 8 or 16 bits")
    if form != _UNSIGNED or bits > 16:
        raise UnreadableImageError("has signed or 32-bit numbers; save 8 or 16 bits, unsigned")
    if photometric == _SEPARATED:
        raise UnreadableImageError("has the colours of a printer (CMYK); save it as RGB")
    if photometric == _WHITE_IS_ZERO and bits > 8:  # OpenCV would show it as a negative
        raise UnreadableImageError("has 0 for white; save it with 0 for black")
