"""The fields in which two protobuf messages of one type differ, without decoding all the others."""

from array import array
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple, TypeAlias

from google.protobuf.descriptor import Descriptor
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_logs.diffing.plain_values import ABSENT, Differing, is_same, leaves
from reflexarc_logs.diffing.plain_values import differing as plain_differing

Plain: TypeAlias = Callable[[Any], Any]
"""Makes plain values of a message."""


class _Field(NamedTuple):
    name: str
    is_message: bool
    is_list: bool
    is_map: bool
    has_presence: bool


def differing(
    a: ProtobufMessage, b: ProtobufMessage, plain: Plain, prefix: str = ""
) -> Iterator[Differing]:
    """Path and both values of each field that is not the same.

    Args:
        a: one message.
        b: another one of the same class.
        plain: what makes nested plain values of a message that only one of them has.
        prefix: what leads to them, with a dot at its end.
    """
    for field in _fields(a.DESCRIPTOR):
        path = prefix + field.name
        if field.has_presence and not (a.HasField(field.name) and b.HasField(field.name)):
            yield from _one_sided(a, b, field, plain, path)
            continue
        x, y = getattr(a, field.name), getattr(b, field.name)
        if field.is_map:
            yield from plain_differing(_plain_map(x, plain), _plain_map(y, plain), path)
        elif field.is_list:
            if not _equal_bits(x, y):
                yield from plain_differing(plain(x), plain(y), path)
        elif field.is_message:
            yield from differing(x, y, plain, f"{path}.")
        elif not is_same(x, y):
            yield path, x, y


def _one_sided(
    a: ProtobufMessage, b: ProtobufMessage, field: _Field, plain: Plain, path: str
) -> Iterator[Differing]:
    if a.HasField(field.name):
        yield from ((p, value, ABSENT) for p, value in leaves(plain(getattr(a, field.name)), path))
    elif b.HasField(field.name):
        yield from ((p, ABSENT, value) for p, value in leaves(plain(getattr(b, field.name)), path))


def _plain_map(x: Any, plain: Plain) -> dict[str, Any]:
    return {str(key): plain(x[key]) for key in x}


def _equal_bits(x: Any, y: Any) -> bool:
    """Whether two lists of numbers are the same for certain; 0.0 and -0.0 are not."""
    try:
        return array("d", x).tobytes() == array("d", y).tobytes()
    except (TypeError, OverflowError):
        return False  # no numbers


@lru_cache(maxsize=1024)
def _fields(descriptor: Descriptor) -> tuple[_Field, ...]:
    proto = DescriptorProto()
    descriptor.CopyToProto(proto)
    repeated = {f.name for f in proto.field if f.label == FieldDescriptorProto.LABEL_REPEATED}
    return tuple(
        _Field(
            f.name,
            is_message=f.message_type is not None,
            is_list=f.name in repeated,
            is_map=f.message_type is not None and f.message_type.GetOptions().map_entry,
            has_presence=f.has_presence,
        )
        for f in descriptor.fields
    )
