"""How much a protobuf message would unfold to, seen before it is parsed.

On the wire an empty message takes two bytes and a small number one; parsed they take a hundred and
eight. So a file of a few megabytes can fill any memory. Here its fields are walked over and counted
without being kept, with the descriptors of ONNX to know which of them are messages themselves.
"""

from typing import Any, TypeAlias

import onnx

from reflexarc_runtime.errors import PolicyError

MOST_FIELDS = 250_000
"""Of a policy, all parts together: a node takes about ten."""
MOST_PACKED_BYTES = 16 << 20
"""Of numbers in packed form, which take eight times as much in memory; weights have another."""

Part: TypeAlias = tuple[int, int, Any]
"""From where to where a message lies, and what it is."""

_VARINT, _FIXED_8, _BYTES, _FIXED_4 = 0, 1, 2, 5
_PACKED = {"dims", "int32_data", "int64_data", "uint64_data", "ints"}


def check_wire(data: bytes) -> None:
    """Check that a model's bytes can be parsed without harm.

    Raises:
        PolicyError: it has too many parts, or is no message.
    """
    try:
        _walk(memoryview(data))
    except (IndexError, KeyError):
        raise PolicyError("expected an ONNX model, got something else; export it again") from None


def _walk(data: memoryview) -> None:
    fields = packed = 0
    parts: list[Part] = [(0, len(data), onnx.ModelProto.DESCRIPTOR)]
    while parts:
        place, end, kind = parts.pop()
        while place < end:
            fields += 1
            _check(fields, packed)
            tag, place = _varint(data, place)
            if not tag >> 3:  # no field has this number
                raise IndexError
            if tag & 7 != _BYTES:
                place = _behind(data, place, tag & 7)
                continue
            size, place = _varint(data, place)
            packed += _enter(parts, place, size, kind, tag >> 3)
            place += size
        if place != end:
            raise IndexError
    _check(fields, packed)


def _check(fields: int, packed: int) -> None:
    if fields > MOST_FIELDS or packed > MOST_PACKED_BYTES:
        raise PolicyError(
            f"expected a policy of at most {MOST_FIELDS} fields, with weights as raw data, got more"
        )


def _enter(parts: list[Part], place: int, size: int, kind: Any, number: int) -> int:
    """Remember a part that has parts itself; how many bytes of packed numbers there are else."""
    field = kind.fields_by_number.get(number)
    if field is None:
        return 0
    if field.message_type is not None:
        parts.append((place, place + size, field.message_type))
        return 0
    return size if field.name in _PACKED else 0


def _behind(data: memoryview, place: int, wire: int) -> int:
    """The place behind a number of this form."""
    if wire == _VARINT:
        return _varint(data, place)[1]
    return place + {_FIXED_8: 8, _FIXED_4: 4}[wire]


def _varint(data: memoryview, place: int) -> tuple[int, int]:
    """A number of seven bits a byte, the lowest first, and the place behind it."""
    value = shift = 0
    while shift < 70:
        byte = data[place]
        value |= (byte & 127) << shift
        place, shift = place + 1, shift + 7
        if byte < 128:
            return value, place
    raise IndexError
