"""One image file: from its bytes to red, green and blue of 8 bits, upright, or the reason why not.

Deep pictures: a value v becomes 255 v / white, rounded. In a file of 16 bits white may be 65535,
or 4095 of a camera of 12 bits, and no field says which. A value of 32768 or more shows that all
16 bits are used; where there is none, the flag `--bits` must tell.
"""

from dataclasses import dataclass
from typing import Any, TypeAlias, cast

import cv2
import numpy as np
import numpy.typing as npt

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.eye import Image
from reflexarc_sim_bridge.body.camera.formats.facts import Facts, UnreadableImageError
from reflexarc_sim_bridge.body.camera.formats.inspect import TIFF_STARTS, inspect
from reflexarc_sim_bridge.body.camera.formats.tiff import upright

FULL_16 = 65535
"""White of a picture that uses 16 bits."""
MOST_PIXELS = 1 << 25
"""Of one picture. A small file may say more, and decoding would take all memory."""
MOST_BYTES = 1 << 28
"""Of one file: more than so many pixels have without any compression."""

_FULL_8 = 255
_HALF_16 = 32768


Values: TypeAlias = npt.NDArray[np.unsignedinteger[Any]]
"""uint8 or uint16."""


@dataclass(frozen=True)
class Picture:
    """The numbers of a file, upright, before it is settled what white is."""

    values: Values
    """(rows, columns, 3): red, green, blue."""
    white: int | None
    """None: the file does not tell, and its numbers do not show it."""

    @property
    def largest(self) -> int:
        """The largest number in it."""
        return int(self.values.max())


def read_picture(data: bytes) -> Picture:
    """Decode the bytes of an image file.

    Raises:
        UnreadableImageError: there is no image, or none that can be shown truly.
    """
    facts = inspect(data)
    if facts.width * facts.height > MOST_PIXELS:
        raise UnreadableImageError(
            f"says that it has {facts.width} × {facts.height} pixels; scale it to "
            f"{MOST_PIXELS // 1_000_000} million at most"
        )
    raw = _decoded(upright(data) if data.startswith(TIFF_STARTS) else data)
    picture = turned(_red_first(raw, facts), facts.orientation)
    return Picture(picture, _white_of(picture, facts))


def eight_bits(picture: Picture, bits: int | None, name: str) -> Image:
    """The picture with 255 for white.

    Args:
        picture: of a file.
        bits: how many the camera gives, as the user says.
        name: of the file, for complaints.

    Raises:
        UsageError: the bits are unknown, or the picture contradicts what is said of them.
    """
    deep = picture.values.dtype == np.uint16
    if bits is not None and not deep:
        raise UsageError(f"--bits {bits}: {name}: expected 16 bits a channel, got 8; leave it out")
    white = picture.white if bits is None else 2**bits - 1
    if white is None:
        raise UsageError(unknown_bits(picture.largest, name))
    if picture.largest > white:
        said = f"--bits {bits}" if bits is not None else "its header"
        raise UsageError(f"{said}: {name}: expected values up to {white}, got {picture.largest}")
    if white == _FULL_8:
        return picture.values.astype(np.uint8)
    return ((picture.values.astype(np.uint32) * _FULL_8 + white // 2) // white).astype(np.uint8)


def unknown_bits(largest: int, name: str) -> str:
    """The complaint about deep pictures whose white is unknown."""
    likely = next(bits for bits in (10, 12, 14, 16) if largest < 2**bits)
    return (
        f"{name}: expected 16 bits a channel in use, got values up to {largest}; "
        f"say how many bits the camera gives: --bits {likely}, or --bits 16 if it was dark"
    )


def turned(values: Values, orientation: int) -> Values:
    """Turn and mirror a picture upright, as Exif counts orientations."""
    if orientation >= 5:  # rows and columns are exchanged
        values = values.swapaxes(0, 1)
    if orientation in (3, 4, 7, 8):
        values = values[::-1]
    return values[:, ::-1] if orientation in (2, 3, 6, 7) else values


def _decoded(data: bytes) -> Values:
    """What OpenCV makes of it, unchanged: without orientation, with its depth and channels."""
    try:
        raw = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:  # too large, or broken in a way that its decoder does not catch
        raw = None
    if raw is None:
        raise UnreadableImageError("cannot be decoded: it is cut, damaged or of a rare kind")
    if raw.dtype not in (np.uint8, np.uint16):
        raise UnreadableImageError(f"has numbers of type {raw.dtype}; save 8 or 16 bits, unsigned")
    return cast("Values", raw)


def _red_first(raw: Values, facts: Facts) -> Values:
    """Three channels; OpenCV puts blue first."""
    if raw.ndim == 2:
        raw = raw[:, :, np.newaxis]
    channels = raw.shape[2]
    if channels == 4 and not facts.pads_colours:
        _refuse_transparent(bool(np.any(raw[:, :, 3] != np.iinfo(raw.dtype).max)))
    else:
        _refuse_transparent(facts.transparent)
    return np.repeat(raw, 3, axis=2) if channels == 1 else raw[:, :, 2::-1]


def _refuse_transparent(is_so: bool) -> None:
    if is_so:
        raise UnreadableImageError(
            "is transparent in places, where nobody saw a colour; save it without transparency"
        )


def _white_of(values: Values, facts: Facts) -> int | None:
    if facts.white is not None:
        return facts.white
    if values.dtype == np.uint8:
        return _FULL_8
    return FULL_16 if int(values.max()) >= _HALF_16 else None
