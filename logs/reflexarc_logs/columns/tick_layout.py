"""Where the fields of a tick stand in its bytes.

The ticks of a log differ in their numbers, and hardly ever in how they are encoded: which fields
are there, and how long each is. A layout says that of one tick: which bits every tick of the same
layout has in the same place (tags, lengths, which bytes of a number are the last ones). Whatever
has these bits decodes to the fields that stand there.
"""

from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from google.protobuf.descriptor import Descriptor, FieldDescriptor

from reflexarc_logs.reading.wire_walk import FieldPlace, UnusualError, WireKind, fields_at
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages_pb2 import Decision, Tick

Octets: TypeAlias = npt.NDArray[np.uint8]

_ALL, _LAST_OR_NOT = 0xFF, 0x80
_DECISION = Tick.DESCRIPTOR.fields_by_name["decision"].number
_NUMBER_BYTES = 5
"""What a number of 32 bits takes at most."""
_OK = bytes([Verdict.OK.value])

_WIRES = {
    FieldDescriptor.TYPE_DOUBLE: WireKind.FIXED_64,
    FieldDescriptor.TYPE_FLOAT: WireKind.FIXED_32,
    FieldDescriptor.TYPE_BYTES: WireKind.BYTES,
    FieldDescriptor.TYPE_STRING: WireKind.BYTES,
    FieldDescriptor.TYPE_MESSAGE: WireKind.BYTES,
}
_SHORT = (FieldDescriptor.TYPE_SINT32, FieldDescriptor.TYPE_UINT32, FieldDescriptor.TYPE_ENUM)


class ByteSpan(NamedTuple):
    """Bytes of a tick."""

    start: int
    end: int


@dataclass(frozen=True)
class TickLayout:
    """The layout of a tick whose verdict is OK, and whose policy was asked."""

    mask: Octets
    """Which bits of the bytes up to `end` are the same in all ticks of this layout."""
    bits: Octets
    """And these bits."""
    spans: dict[str, ByteSpan]
    """The values of the decision's own fields that are there, by name."""

    @property
    def end(self) -> int:
        """Where the decision ends; what follows is how punctual the tick was."""
        return len(self.mask)

    def size(self, name: str) -> int:
        """Bytes of a field; 0 if it is not there."""
        start, end = self.spans.get(name, (0, 0))
        return end - start


def layout_of(tick: bytes, policy_hash: str) -> TickLayout | None:
    """The layout of a tick; None if it is not the usual one of a tick at which all is well.

    Args:
        tick: its bytes.
        policy_hash: which policy it may name; empty: any.
    """
    walker = _Walker(tick)
    try:
        outer = next(fields_at(tick, 0, len(tick)), None)
        if outer is None or (outer.number, outer.wire) != (_DECISION, WireKind.BYTES):
            return None
        walker.fix(outer.head, outer.start, _ALL)
        descriptor: Descriptor = Decision.DESCRIPTOR  # type: ignore[assignment]  # one of two stubs
        spans = walker.walk(descriptor, outer.start, outer.end)
    except UnusualError:
        return None
    if not _is_usual(tick, spans, policy_hash):
        return None
    for name in ("policy_hash", "verdict"):
        walker.fix(*spans.get(name, (0, 0)), _ALL)
    mask = walker.mask[: outer.end]
    return TickLayout(mask, np.frombuffer(tick, np.uint8)[: outer.end] & mask, spans)


def _is_usual(tick: bytes, spans: dict[str, ByteSpan], policy_hash: str) -> bool:
    """Whether the policy named was asked, and all is well."""
    if not spans.keys() >= {"retina", "q_values", "verdict", "command"} or "reason" in spans:
        return False
    named = tick[slice(*spans.get("policy_hash", (0, 0)))]
    is_named = not named or not policy_hash or named == policy_hash.encode()
    return is_named and named.isascii() and tick[slice(*spans["verdict"])] == _OK


class _Walker:
    """Walks through the messages of a tick, and notes which bits its layout is made of."""

    def __init__(self, tick: bytes) -> None:
        self._tick = tick
        self.mask: Octets = np.zeros(len(tick), np.uint8)

    def fix(self, start: int, end: int, bits: int) -> None:
        """These bits of these bytes belong to the layout."""
        self.mask[start:end] = bits

    def walk(self, descriptor: Descriptor, start: int, end: int) -> dict[str, ByteSpan]:
        """Where the fields of a message stand, by name.

        Raises:
            UnusualError: see `fields_at`; or a field that is not known here.
        """
        spans = {}
        for place in fields_at(self._tick, start, end):
            field = descriptor.fields_by_number.get(place.number)
            if field is None:
                raise UnusualError
            self._note(field, place)
            spans[field.name] = ByteSpan(place.start, place.end)
        return spans

    def _note(self, field: FieldDescriptor, place: FieldPlace) -> None:
        is_packed = _is_repeated(field)
        expected = WireKind.BYTES if is_packed else _WIRES.get(field.type, WireKind.VARINT)
        size = place.end - place.start
        if place.wire is not expected or (is_packed and size % 4):
            raise UnusualError
        self.fix(place.head, place.start, _ALL)
        if expected is WireKind.VARINT:
            if field.type in _SHORT and size > _NUMBER_BYTES:
                raise UnusualError
            self.fix(place.start, place.end, _LAST_OR_NOT)
        elif field.message_type is not None:
            inner: Descriptor = field.message_type
            self.walk(inner, place.start, place.end)


def _is_repeated(field: FieldDescriptor) -> bool:
    """Of a decision's repeated fields each is of float: `q_values` and `state`."""
    return field.name in ("q_values", "state")
