"""PBM, PGM and PPM: their headers say what white is (Netpbm)."""

import re

from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError

_GAP = rb"(?:\s|#[^\n]*\n)+"  # no repetition within the repetition: it would try them all
_SIZE = (_GAP + rb"([0-9]{1,10})") * 2
_BLACK_AND_WHITE = re.compile(rb"P[14]" + _SIZE)
_HEAD = re.compile(rb"P[2356]" + _SIZE + _GAP + rb"([0-9]{1,10})\s")
_FULL_16 = 65535


def facts_of_pnm(data: bytes) -> Facts:
    """What a PNM tells: OpenCV shows binary numbers and deep ones as they are.

    Raises:
        UnreadableImageError: its header is broken.
    """
    is_bits = data[:2] in (b"P1", b"P4")
    head = (_BLACK_AND_WHITE if is_bits else _HEAD).match(data)
    if head is None:
        raise UnreadableImageError("has a broken header")
    width, height, *whites = map(int, head.groups())
    return Facts(white=None if is_bits else _white(data, *whites), width=width, height=height)


def _white(data: bytes, white: int) -> int | None:
    if not 0 < white <= _FULL_16:
        raise UnreadableImageError("has a broken header")
    if white < 256 and data[:2] in (b"P2", b"P3"):
        return 255  # OpenCV widens small numbers in digits
    # Many programs write 65535 for whatever their camera had: no word of what white is.
    return None if white == _FULL_16 else white
