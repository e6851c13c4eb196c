"""The order in which the fields of a protobuf message stand in its bytes: a plan to read others by.

Messages of one stream differ in their values and hardly ever in which fields are there. A plan says
that of one message; whatever has the same tags in the same order is read by it, thousands at once.

Only what is encoded in the usual way has a plan: proto3, fields by growing number and each once,
numbers of 63 bits, lists of floating-point numbers packed, no maps, no lists of messages. Whoever
meets something else decodes it.
"""

from collections.abc import Callable, Iterator
from enum import Enum, auto
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from google.protobuf.descriptor import Descriptor, FieldDescriptor
from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
)
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_logs.reading.wire_walk import FieldPlace, UnusualError, WireKind, fields_at

IsIgnored: TypeAlias = Callable[[str], bool]

MOST_DEPTH = 16
"""A type may hold itself."""

VARINTS = {
    FieldDescriptor.TYPE_INT64: (1 << 63) - 1,
    FieldDescriptor.TYPE_UINT64: (1 << 63) - 1,
    FieldDescriptor.TYPE_SINT64: (1 << 63) - 1,
    FieldDescriptor.TYPE_INT32: (1 << 31) - 1,
    FieldDescriptor.TYPE_ENUM: (1 << 31) - 1,
    FieldDescriptor.TYPE_UINT32: (1 << 32) - 1,
    FieldDescriptor.TYPE_SINT32: (1 << 32) - 1,
    FieldDescriptor.TYPE_BOOL: 1,
}
"""The largest number, as encoded, that decodes to itself: more bits are cut off."""
ZIGZAG = (FieldDescriptor.TYPE_SINT32, FieldDescriptor.TYPE_SINT64)
FIXED = {
    FieldDescriptor.TYPE_DOUBLE: "<f8",
    FieldDescriptor.TYPE_FLOAT: "<f4",
    FieldDescriptor.TYPE_FIXED32: "<u4",
    FieldDescriptor.TYPE_SFIXED32: "<i4",
    FieldDescriptor.TYPE_FIXED64: "<i8",
    FieldDescriptor.TYPE_SFIXED64: "<i8",
}
_OCTETS = (FieldDescriptor.TYPE_BYTES, FieldDescriptor.TYPE_STRING)
_LISTS = (FieldDescriptor.TYPE_DOUBLE, FieldDescriptor.TYPE_FLOAT)
_FIXED_WIRES = {"4": WireKind.FIXED_32, "8": WireKind.FIXED_64}


class StepKind(Enum):
    """What stands behind a tag."""

    VARINT = auto()
    FIXED = auto()
    OCTETS = auto()
    LIST = auto()
    OPEN = auto()
    """A message begins."""
    CLOSE = auto()
    """It ends; there is no tag."""
    PASSED_OVER = auto()
    """A message that nobody looks into."""


class Step(NamedTuple):
    """One field, in the order of the bytes."""

    kind: StepKind
    tag: bytes
    path: str
    """As `decision.q_values`."""
    type: int
    """Of the field: `FieldDescriptor.TYPE_…`."""
    has_presence: bool
    """Whether a message without it says something else than one with its usual value."""


Plan: TypeAlias = tuple[Step, ...]


def plan_of(payload: bytes, kind: type[ProtobufMessage], is_ignored: IsIgnored) -> Plan | None:
    """The plan by which a message is read; None if it is not encoded in the usual way.

    Args:
        payload: the message.
        kind: its class.
        is_ignored: whether nobody compares a field.
    """
    descriptor: Descriptor = kind.DESCRIPTOR  # type: ignore[assignment]  # one of two stubs
    try:
        kind.FromString(payload)  # tags and lengths may be too long
        return tuple(_steps(payload, descriptor, 0, len(payload), (), is_ignored))
    except (UnusualError, DecodeError):
        return None


def _steps(
    data: bytes,
    descriptor: Descriptor,
    start: int,
    end: int,
    above: tuple[str, ...],
    is_ignored: IsIgnored,
) -> Iterator[Step]:
    known, chosen = _fields_of(descriptor), set[str]()
    if len(above) > MOST_DEPTH:
        raise UnusualError
    for place in fields_at(data, start, end):
        field = known.get(place.number)
        if field is None or field.choice in chosen:
            raise UnusualError
        chosen |= {field.choice} if field.choice else set()
        names = (*above, field.name)
        step = _step(data, field, place, ".".join(names))
        if step.kind is not StepKind.OPEN:
            yield step
        elif not above and is_ignored(step.path):
            yield step._replace(kind=StepKind.PASSED_OVER)
        else:
            yield step
            assert field.message_type is not None
            yield from _steps(data, field.message_type, place.start, place.end, names, is_ignored)
            yield Step(StepKind.CLOSE, b"", step.path, field.type, has_presence=False)


def _step(data: bytes, field: "_Field", place: FieldPlace, path: str) -> Step:
    kind, wire = _expected(field)
    if place.wire is not wire:
        raise UnusualError
    return Step(kind, _tag(data, place), path, field.type, field.has_presence)


def _expected(field: "_Field") -> tuple[StepKind, WireKind]:
    """What stands behind its tag, and how that is encoded."""
    if field.is_list:
        if field.type in _LISTS:
            return StepKind.LIST, WireKind.BYTES
    elif field.type in VARINTS:
        return StepKind.VARINT, WireKind.VARINT
    elif field.type in FIXED:
        return StepKind.FIXED, _FIXED_WIRES[FIXED[field.type][-1]]
    elif field.type in _OCTETS:
        return StepKind.OCTETS, WireKind.BYTES
    elif field.message_type is not None:
        return StepKind.OPEN, WireKind.BYTES
    raise UnusualError


def _tag(data: bytes, place: FieldPlace) -> bytes:
    """The bytes of its tag alone, without a length."""
    end = place.head + 1
    while data[end - 1] & 0x80:
        end += 1
    return data[place.head : end]


class _Field(NamedTuple):
    name: str
    type: int
    is_list: bool
    has_presence: bool
    choice: str
    """The name of the `oneof` that it belongs to; empty: none."""
    message_type: Descriptor | None


@lru_cache(maxsize=1024)
def _fields_of(descriptor: Descriptor) -> dict[int, _Field]:
    """The fields of a type by their numbers.

    Raises:
        UnusualError: it is not of proto3: enumerations are closed there, fields required.
    """
    file, proto = FileDescriptorProto(), DescriptorProto()
    descriptor.file.CopyToProto(file)
    if file.syntax != "proto3":
        raise UnusualError
    descriptor.CopyToProto(proto)
    repeated = {f.name for f in proto.field if f.label == FieldDescriptorProto.LABEL_REPEATED}
    return {
        f.number: _Field(
            f.name,
            f.type,
            f.name in repeated,
            f.has_presence,
            f.containing_oneof.name if f.containing_oneof is not None else "",
            f.message_type,
        )
        for f in descriptor.fields
    }
