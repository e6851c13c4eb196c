"""PBM, PGM and PPM: their headers say what white is (Netpbm)."""

import re

from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

_GAP = rb"(?:\s|#[^\n]*\n)+"  # no repetition within the repetition: it would try them all
_HEAD = re.compile(rb"P[2356]" + (_GAP + rb"[0-9]{1,10}") * 2 + _GAP + rb"([0-9]{1,10})\s")
_FULL_16 = 65535


def facts_of_pnm(data: bytes) -> Facts:
    """What a PNM tells: OpenCV shows binary numbers and deep ones as they are.

    Raises:
        UnreadableImageError: its header is broken.
    """
    if data[:2] in (b"P1", b"P4"):
        return Facts()
    head = _HEAD.match(data)
    if head is None or not 0 < (white := int(head[1])) <= _FULL_16:
        raise UnreadableImageError("has a broken header")
    if white < 256 and data[:2] in (b"P2", b"P3"):
        return Facts(white=255)  # OpenCV widens small numbers in digits
    # Many programs write 65535 for whatever their camera had: no word of what white is.
    return Facts(white=None if white == _FULL_16 else white)
