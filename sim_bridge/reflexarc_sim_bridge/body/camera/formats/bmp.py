"""BMP: two headers without compression or checksum (Microsoft, BITMAPINFOHEADER)."""

import struct

from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

_OLD_HEADER_BYTES = 12


def facts_of_bmp(data: bytes) -> Facts:
    """What a BMP tells. Its fourth byte is reserved; rows from the top down count as negative.

    Raises:
        UnreadableImageError: it is cut.
    """
    if len(data) < 26:
        raise UnreadableImageError("is cut")
    (header_bytes,) = struct.unpack_from("<I", data, 14)
    form = "<HH" if header_bytes == _OLD_HEADER_BYTES else "<ii"
    width, height = struct.unpack_from(form, data, 18)
    return Facts(pads_colours=True, width=abs(width), height=abs(height))
