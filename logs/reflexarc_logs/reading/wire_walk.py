"""Walks through a protobuf message as it is encoded, and says where each of its fields stands.

Only what a writer makes in the usual way is walked: fields by growing number, each once, numbers of
nine bytes at most. Of everything else it says nothing, and it is decoded as usual.
"""

from collections.abc import Iterator
from enum import IntEnum
from typing import NamedTuple

MOST_VARINT_BYTES = 9
"""So many hold 63 bits."""


class WireKind(IntEnum):
    """How a field is encoded."""

    VARINT = 0
    FIXED_64 = 1
    BYTES = 2
    FIXED_32 = 5


_FIXED = {WireKind.FIXED_64: 8, WireKind.FIXED_32: 4}
_KINDS = frozenset(WireKind)


class UnusualError(ValueError):
    """Not encoded in the usual way."""


class FieldPlace(NamedTuple):
    """A field of a message, in bytes from its beginning."""

    number: int
    wire: WireKind
    head: int
    """Where its tag begins; its length, if it has one, follows."""
    start: int
    """Where its value begins."""
    end: int


def fields_at(data: bytes, start: int, end: int) -> Iterator[FieldPlace]:
    """The fields of the message that stands there.

    Raises:
        UnusualError: it is not encoded in the usual way, or no message at all.
    """
    before = 0
    while start < end:
        head = start
        tag, start = _varint(data, start, end)
        number, kind = tag >> 3, tag & 7
        if number <= before or kind not in _KINDS:
            raise UnusualError
        wire, before = WireKind(kind), number
        if wire is WireKind.VARINT:
            stop = _varint(data, start, end)[1]
        elif wire is WireKind.BYTES:
            size, start = _varint(data, start, end)
            stop = start + size
        else:
            stop = start + _FIXED[wire]
        if stop > end:
            raise UnusualError
        yield FieldPlace(number, wire, head, start, stop)
        start = stop


def _varint(data: bytes, start: int, end: int) -> tuple[int, int]:
    """A number, and where it ends."""
    value = 0
    for at in range(start, min(end, start + MOST_VARINT_BYTES)):
        value |= (data[at] & 0x7F) << (7 * (at - start))
        if data[at] < 0x80:
            return value, at + 1
    raise UnusualError
