"""Compares two protobuf messages field by field, in the fields that both descriptors have.

Floating-point values are compared in bits: 0.0 is not -0.0, and one NaN equals another only bit
for bit. A field that only one of the two descriptors knows is named as not compared: it is newer
than the log, or newer than this package.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from google.protobuf.descriptor import Descriptor, FieldDescriptor
from google.protobuf.descriptor_pb2 import DescriptorProto
from google.protobuf.empty_pb2 import Empty
from google.protobuf.message import Message as ProtobufMessage

_SHOWN = 80
"""Characters of a value that a report shows."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A field that has another value after the replay than in the log."""

    path: str
    """As `command.linear_mps`, `q_values[1]`, `retina[5]`."""
    recorded: str
    replayed: str


@dataclass(frozen=True, slots=True)
class Shared:
    """A field that both descriptors have; for a message, with the fields inside it."""

    field: FieldDescriptor
    inside: tuple["Shared", ...]


class Fields:
    """The fields that a message of a log and one of this version have in common.

    Args:
        ours: the descriptor of this package.
        theirs: the descriptor that the log carries.
    """

    def __init__(self, ours: Descriptor, theirs: Descriptor) -> None:
        self._not_compared: list[str] = []
        self._shared = self._match(ours, theirs, "")
        self.count = _leaves(self._shared)
        """How many fields one comparison looks at; a repeated one counts once."""

    @property
    def not_compared(self) -> tuple[str, ...]:
        """Paths of the fields that only one of the two knows."""
        return tuple(self._not_compared)

    def compares(self, name: str) -> bool:
        """Whether both know this field of the message itself."""
        return any(shared.field.name == name for shared in self._shared)

    def differences(
        self, recorded: ProtobufMessage, replayed: ProtobufMessage
    ) -> Iterator[Difference]:
        """Every field that is not the same, in the order of the descriptor."""
        if recorded.SerializeToString(deterministic=True) == replayed.SerializeToString(
            deterministic=True
        ):
            return
        yield from _walk(self._shared, recorded, replayed, "")

    def _match(self, ours: Descriptor, theirs: Descriptor, prefix: str) -> tuple[Shared, ...]:
        own, other = _shapes(ours), _shapes(theirs)
        shared = [name for name in own if own[name] == other.get(name)]
        strangers = {**own, **other}.keys() - set(shared)
        self._not_compared.extend(sorted(prefix + name for name in strangers))
        return tuple(self._pair(ours, theirs, name, prefix) for name in shared)

    def _pair(self, ours: Descriptor, theirs: Descriptor, name: str, prefix: str) -> Shared:
        field = ours.fields_by_name[name]
        if field.message_type is None:
            return Shared(field, ())
        inner = message_type(theirs, name)
        return Shared(field, self._match(field.message_type, inner, f"{prefix}{name}."))


def message_type(descriptor: Descriptor, name: str) -> Descriptor:
    """The descriptor of the message in a field; an empty one where the field holds no message."""
    field = descriptor.fields_by_name.get(name)
    inner = None if field is None else field.message_type
    return Empty.DESCRIPTOR if inner is None else inner


def _shapes(descriptor: Descriptor) -> dict[str, tuple[Any, ...]]:
    """What makes a field the same field: number, type, repetition, presence."""
    proto = DescriptorProto()
    descriptor.CopyToProto(proto)
    return {f.name: (f.number, f.type, f.label, f.proto3_optional) for f in proto.field}


def _leaves(shared: tuple[Shared, ...]) -> int:
    return sum(_leaves(s.inside) if s.field.message_type is not None else 1 for s in shared)


def _walk(
    shared: tuple[Shared, ...], recorded: Any, replayed: Any, prefix: str
) -> Iterator[Difference]:
    for one in shared:
        name = one.field.name
        path = prefix + name
        if one.field.has_presence:
            present = recorded.HasField(name), replayed.HasField(name)
            if present[0] != present[1]:
                yield Difference(path, *("set" if p else "absent" for p in present))
            if not all(present):
                continue
        values = getattr(recorded, name), getattr(replayed, name)
        if one.field.message_type is not None:
            yield from _walk(one.inside, *values, f"{path}.")
        else:
            yield from _values(path, *values)


def _values(path: str, recorded: Any, replayed: Any) -> Iterator[Difference]:
    """Scalars, and sequences of them: strings of bytes and repeated fields."""
    if not isinstance(recorded, bytes) and not _is_repeated(recorded):
        if _bits(recorded) != _bits(replayed):
            yield Difference(path, _shown(recorded), _shown(replayed))
    elif len(recorded) != len(replayed):
        yield Difference(path, f"{len(recorded)} values", f"{len(replayed)} values")
    else:
        for i, (old, new) in enumerate(zip(recorded, replayed, strict=True)):
            if _bits(old) != _bits(new):
                yield Difference(f"{path}[{i}]", repr(old), repr(new))


def _is_repeated(value: Any) -> bool:
    return not isinstance(value, str) and hasattr(value, "__len__")


def _shown(value: Any) -> str:
    """A value in a report: on one line, and not longer than one."""
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"


def _bits(value: Any) -> Any:
    return struct.pack("<d", value) if isinstance(value, float) else value
