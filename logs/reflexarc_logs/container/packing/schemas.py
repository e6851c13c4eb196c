"""The schema of a protobuf message: a `FileDescriptorSet` of what it is made of, nothing else.

The files whole would be 4 KB in each of eight channels, of which most need a hundred bytes; they
stand in each part twice, the second time uncompressed.
"""

from collections.abc import Iterator

from google.protobuf.descriptor import Descriptor, EnumDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorProto, FileDescriptorSet
from google.protobuf.message import Message as ProtobufMessage
from mcap.records import Schema
from mcap_protobuf.schema import build_file_descriptor_set

NO_SCHEMA = 0
PROTOBUF = "protobuf"


def schema_of(kind: type[ProtobufMessage]) -> Schema:
    """The schema of a protobuf message, with all that it is made of."""
    data = descriptors_of(kind).SerializeToString(deterministic=True)
    return Schema(id=NO_SCHEMA, name=kind.DESCRIPTOR.full_name, encoding=PROTOBUF, data=data)


def descriptors_of(kind: type[ProtobufMessage]) -> FileDescriptorSet:
    """The files of a message, each without what the message does not need."""
    needed = {_outermost(part).full_name for part in _parts(kind.DESCRIPTOR)}  # type: ignore[arg-type]  # the stub's two names of one class
    files = build_file_descriptor_set(kind).file
    for file in files:
        _reduce(file, needed)
    kept = {file.name for file in files if file.message_type or file.enum_type}
    for file in files:
        dependencies = [name for name in file.dependency if name in kept]
        del file.dependency[:]
        file.dependency.extend(dependencies)
    return FileDescriptorSet(file=[file for file in files if file.name in kept])


def _parts(root: Descriptor | EnumDescriptor) -> Iterator[Descriptor | EnumDescriptor]:
    """A message, all messages and enumerations in its fields, and theirs."""
    known: set[str] = set()
    waiting: list[Descriptor | EnumDescriptor] = [root]
    while waiting:
        part = waiting.pop()
        if part.full_name in known:
            continue
        known.add(part.full_name)
        yield part
        if isinstance(part, Descriptor):
            waiting += [_outermost(part), *part.nested_types]
            waiting += [f.message_type for f in part.fields if f.message_type is not None]
            waiting += [f.enum_type for f in part.fields if f.enum_type is not None]


def _outermost(part: Descriptor | EnumDescriptor) -> Descriptor | EnumDescriptor:
    """The part of a file that this one stands in: itself, or what it is nested in."""
    while part.containing_type is not None:
        part = part.containing_type
    return part


def _reduce(file: FileDescriptorProto, needed: set[str]) -> None:
    """Leave out other messages and enumerations, services and extensions."""
    prefix = f"{file.package}." if file.package else ""
    messages = [m for m in file.message_type if prefix + m.name in needed]
    enumerations = [e for e in file.enum_type if prefix + e.name in needed]
    for beside in ("message_type", "enum_type", "service", "extension"):
        file.ClearField(beside)
    for numbers in ("public_dependency", "weak_dependency"):  # of files that may be gone
        file.ClearField(numbers)
    file.message_type.extend(messages)
    file.enum_type.extend(enumerations)
