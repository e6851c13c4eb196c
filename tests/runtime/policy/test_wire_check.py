"""The walk over a model's bytes counts what parsing them would make."""

from contextlib import suppress

import onnx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy import wire_check
from reflexarc_runtime.policy.wire_check import check_wire
from support.policies import SMALL, exported


def fields_of(message: object) -> int:
    """The fields of a message and of all within it, as the parser has them."""
    total = 0
    for field, value in message.ListFields():  # type: ignore[attr-defined]  # any message
        values = value if isinstance(value, (list, tuple)) or hasattr(value, "append") else [value]
        if field.type == field.TYPE_MESSAGE:
            total += sum(1 + fields_of(each) for each in values)
        else:
            total += 1 if field.is_packed else len(values)
    return total


def test_the_count_is_that_of_the_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    data = exported(SMALL)
    count = fields_of(onnx.ModelProto.FromString(data))
    monkeypatch.setattr(wire_check, "MOST_FIELDS", count)
    check_wire(data)
    monkeypatch.setattr(wire_check, "MOST_FIELDS", count - 1)
    with pytest.raises(PolicyError, match=f"at most {count - 1} fields"):
        check_wire(data)


def test_packed_numbers_are_bounded_by_their_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    tensor = onnx.TensorProto(int64_data=[1] * 100, data_type=onnx.TensorProto.INT64, dims=[100])
    data = onnx.ModelProto(graph=onnx.GraphProto(initializer=[tensor])).SerializeToString()
    check_wire(data)
    monkeypatch.setattr(wire_check, "MOST_PACKED_BYTES", 99)
    with pytest.raises(PolicyError, match="raw data"):
        check_wire(data)


@given(place=st.integers(0, 500), byte=st.integers(0, 255))
def test_what_the_parser_refuses_or_takes_never_breaks_the_walk(place: int, byte: int) -> None:
    data = bytearray(exported(SMALL))
    data[place % len(data)] = byte
    with suppress(PolicyError):
        check_wire(bytes(data))


@pytest.mark.parametrize(
    "data", [b"\xff" * 11, b"\x0a", b"\x3a\x05\x0a", b"\x0b", b"\x3a\xff\x01", bytes(99)]
)
def test_what_is_no_message_is_refused(data: bytes) -> None:
    with pytest.raises(PolicyError, match="expected an ONNX model"):
        check_wire(data)
