"""A protobuf type with every kind of field, and messages of it written in every way."""

import random
import struct
from typing import Any

from google.protobuf.descriptor_pb2 import (
    DescriptorProto,
    FieldDescriptorProto,
    FileDescriptorProto,
    FileDescriptorSet,
)

from reflexarc_logs.diffing.message_file import Stream
from reflexarc_logs.diffing.payloads import protobuf_class

_NUMBERS = (
    *("double", "float", "int64", "uint64", "int32", "fixed64", "fixed32", "bool"),
    *("uint32", "sfixed32", "sfixed64", "sint32", "sint64"),
)
_FLOATS = [-0.0, 1.5, -2.25, float("nan"), float("inf"), float("-inf"), 1e300, 3e-45]
_SMALL = [-0.0, 1.5, -2.25, float("nan"), float("inf"), 3.0e38]
_LIMITS = {"int64": 63, "uint64": 64, "int32": 31, "uint32": 32, "fixed64": 64, "fixed32": 32}
_LIMITS |= {"sfixed32": 31, "sfixed64": 63, "sint32": 31, "sint64": 63}


def odd_stream(syntax: str = "proto3", topic: str = "/odd") -> Stream:
    """A stream of such messages."""
    file = FileDescriptorProto(name="odd.proto", package="odd", syntax=syntax)
    kinds = file.enum_type.add(name="Kind")
    for number, name in enumerate(("NONE", "SOME", "MANY")):
        kinds.value.add(name=name, number=number)
    odd = file.message_type.add(name="Odd")
    for number, name in enumerate(_NUMBERS, 1):
        _add(odd, f"a_{name}", number, name)
    # Declared in another order than they are numbered: a report goes by the declaration.
    _add(odd, "text", 40, "string")
    _add(odd, "kind", 22, "enum", ".odd.Kind")
    _add(odd, "octets", 21, "bytes")
    _add(odd, "doubles", 23, "double", many=True)
    _add(odd, "floats", 24, "float", many=True)
    _add(odd, "whole", 25, "int32", many=True)
    _add(odd, "inner", 26, "message", ".odd.Odd")
    _add(odd, "inners", 27, "message", ".odd.Odd", many=True)
    _add(odd, "passed", 28, "message", ".odd.Odd")
    entry = odd.nested_type.add(name="CountsEntry")
    entry.options.map_entry = True
    _add(entry, "key", 1, "string")
    _add(entry, "value", 2, "int32")
    _add(odd, "counts", 29, "message", ".odd.Odd.CountsEntry", many=True)
    odd.oneof_decl.add(name="choice")
    for number, name in ((30, "int32"), (31, "string")):
        _add(odd, f"choice_{name}", number, name).oneof_index = 0
    if syntax == "proto3":
        odd.oneof_decl.add(name="_maybe")
        maybe = _add(odd, "maybe", 32, "double")
        maybe.oneof_index, maybe.proto3_optional = 1, True
    return Stream(
        topic, "odd.Odd", "protobuf", "protobuf", FileDescriptorSet(file=[file]).SerializeToString()
    )


def _add(
    message: DescriptorProto, name: str, number: int, kind: str, of: str = "", *, many: bool = False
) -> FieldDescriptorProto:
    label = FieldDescriptorProto.LABEL_REPEATED if many else FieldDescriptorProto.LABEL_OPTIONAL
    code = FieldDescriptorProto.Type.Value(f"TYPE_{kind.upper()}")
    named = {"type_name": of} if of else {}
    return message.field.add(name=name, number=number, type=code, label=label, **named)


def odd_payload(draw: random.Random, stream: Stream, *, oddness: float) -> bytes:
    """A message of it; `oddness`: how often something unusual is in it."""
    kind = protobuf_class(stream)
    assert kind is not None
    message: Any = kind()
    _fill(draw, message, oddness, depth=0)
    payload = message.SerializeToString()
    return draw.choice(twists(draw, payload)) if draw.random() < oddness else payload


def _fill(draw: random.Random, message: Any, oddness: float, depth: int) -> None:
    for name in _NUMBERS:
        if draw.random() < 0.98:
            setattr(message, f"a_{name}", _number(draw, name, oddness))
    message.text = draw.choice(["a", "bc", "wx"] + ["é"] * (draw.random() < oddness))
    message.octets = draw.choice([b"\xff", b"ab", b"ac"])
    message.kind = draw.randrange(1, 3)
    counts = [draw.randrange(4) if draw.random() < oddness else usual for usual in (2, 3)]
    message.doubles.extend(draw.choice([0.0, *_FLOATS]) for _ in range(counts[0]))
    message.floats.extend(draw.choice([0.0, *_SMALL]) for _ in range(counts[1]))
    _fill_rarely(draw, message, oddness, depth)
    if depth < 1:
        for inner in ("inner", "passed"):
            if draw.random() > oddness:
                _fill(draw, getattr(message, inner), oddness, depth + 1)


def _fill_rarely(draw: random.Random, message: Any, oddness: float, depth: int) -> None:
    if draw.random() < oddness:
        message.whole.extend([draw.randrange(3), -1])
    if draw.random() < oddness:
        message.counts[draw.choice("xy")] = draw.randrange(3)
    if draw.random() < oddness and depth < 1:
        message.inners.add().a_int32 = draw.randrange(3)
    if draw.random() < oddness:
        setattr(message, *draw.choice([("choice_int32", 0), ("choice_string", "c")]))
    if draw.random() > oddness and "maybe" in message.DESCRIPTOR.fields_by_name:
        message.maybe = draw.choice(_FLOATS)


def _number(draw: random.Random, name: str, oddness: float) -> Any:
    if name in ("double", "float"):
        return draw.choice(_FLOATS if name == "double" else _SMALL)
    if name == "bool":
        return draw.random() < 0.95
    bits = _LIMITS[name]
    value = draw.choice([1, 2, 3, 127, 128, 300, (1 << 31) - 1])
    if draw.random() < oddness:
        value = (1 << bits) - 1 - draw.randrange(3)
    return -value - 1 if name[0] in "is" and draw.random() < oddness else value


def twists(draw: random.Random, payload: bytes) -> list[bytes]:
    """The same, or another message, in bytes as few writers write them."""
    return [
        payload + b"\xf8\x3f\x07",  # field 1023, which nobody knows
        payload + b"\xc5\x01" + struct.pack("<f", 1.5),  # field 24, not packed
        b"\xf0\x01\x05\xfa\x01\x01c",  # fields 30 and 31, of one choice
        b"\xf0\x01\x06\xfa\x01\x01c",  # the same: only the last one counts
        b"\x18\x85\x00\x20\x05",  # field 3, in more bytes than it takes
        b"\x28\xff\xff\xff\xff\x7f",  # field 5, of 32 bits, in 35
        b"\x40\x02",  # field 8, a truth that is 2
        b"\xb0\x01\x07",  # field 22, a kind that has no name
        b"\xb0\x01\x08",  # another one
        b"\xc2\x02\x01\xff",  # field 40, no text
        payload + b"\x18\x05",  # field 3 behind all others, perhaps twice
        payload[: draw.randrange(len(payload) + 1)],
        b"\x1a" + payload,
        b"",
        b"\xe2\x01\x02\x18\xff",  # field 28, cut short inside
        b"\xd2\x01\x80\x80\x80\x80\x80\x00",  # field 26, its length in six bytes
        bytes(draw.randrange(256) for _ in range(draw.randrange(12))),
    ]
