"""What a message says, field by field: protobuf, the CDR of ROS 2, and JSON.

A payload becomes nested dictionaries and lists of plain values, whatever it was written in. What
nobody here can decode is compared as bytes.
"""

import json
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from google.protobuf.descriptor import Descriptor, FieldDescriptor
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.message_factory import GetMessageClass

from reflexarc_logs.diffing.message_file import Stream
from reflexarc_logs.diffing.plain_values import Differing, Value
from reflexarc_logs.diffing.plain_values import differing as plain_differing
from reflexarc_logs.diffing.protobuf_walk import differing as protobuf_differing

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

Decode: TypeAlias = Callable[[bytes], Value]

BYTES_FIELD = "payload"
"""The only field of a message that cannot be decoded."""

_DEEPEST = 8
"""A type may hold itself."""


class UnreadableError(ValueError):
    """A payload that is not what its schema says."""


class Payloads:
    """The payloads of a stream in two files.

    Args:
        a: the stream in one file.
        b: in the other one; what it carries may have changed.
        is_ignored: whether a field is passed over.
    """

    def __init__(self, a: Stream, b: Stream, is_ignored: Callable[[str], bool]) -> None:
        self._decoders = decoder_of(a), decoder_of(b)
        self._is_one_kind = a.type_name == b.type_name and a[2:] == b[2:]
        self.kind = protobuf_class(a) if self._is_one_kind else None
        """The class of the messages, where both sides have the same."""
        self._strip = None if self.kind is None else _stripping(self.kind, is_ignored)
        self.are_decoded = _as_bytes not in self._decoders
        """Whether fields are told apart; else they are compared as bytes."""
        if not self.are_decoded:
            self._decoders = _as_bytes, _as_bytes

    def are_equal(self, a: bytes, b: bytes) -> bool:
        """Whether two payloads are the same bytes, and mean the same."""
        return self._is_one_kind and a == b

    def equal(self, a: bytes, b: bytes) -> bool:
        """Whether two payloads are the same to the last bit, but for fields that are ignored."""
        if a == b or self._strip is None:
            return self.are_equal(a, b)
        try:
            return self._strip(a) == self._strip(b)
        except UnreadableError:
            return False

    def differing(self, a: bytes, b: bytes) -> Iterator[Differing]:
        """Path and both values of each field that is not the same; ignored ones, too.

        Raises:
            UnreadableError: a payload is not what its schema says.
        """
        if self.kind is not None:
            yield from protobuf_differing(_parsed(self.kind, a), _parsed(self.kind, b), _plain)
        else:
            yield from plain_differing(self._decoders[0](a), self._decoders[1](b))


def decoder_of(stream: Stream) -> Decode:
    """How the payloads of a stream are decoded.

    Where the extra `ros2` is missing, or the schema is malformed, they are compared as bytes.
    """
    try:
        if (kind := protobuf_class(stream)) is not None:
            return lambda payload: _fields(_parsed(kind, payload))
        if stream.encoding == "json":
            return _json
        if stream.encoding == "cdr" and stream.schema_encoding == "ros2msg":
            return _cdr(stream)
    except (ImportError, UnreadableError):
        pass
    return _as_bytes


def protobuf_class(stream: Stream) -> type[ProtobufMessage] | None:
    """The class of a stream's messages, if they are protobuf and it says which."""
    if (stream.schema_encoding or stream.encoding) != "protobuf":
        return None
    try:
        return _message_class(stream.schema, stream.type_name)
    except UnreadableError:
        return None


def _stripping(
    kind: type[ProtobufMessage], is_ignored: Callable[[str], bool]
) -> Callable[[bytes], bytes] | None:
    """What is left of a payload when the ignored fields are taken out of it, as bytes.

    It tells most pairs that agree apart from those that have to be walked, at a tenth of the cost.
    None: there is nothing to take out.
    """
    descriptor: Descriptor = kind.DESCRIPTOR  # type: ignore[assignment]  # one of two stubs
    chains = tuple(_ignored_chains(descriptor, is_ignored, ()))

    def strip(payload: bytes) -> bytes:
        message = _parsed(kind, payload)
        for chain in chains:
            _clear(message, chain)
        return message.SerializeToString(deterministic=True)

    return strip if chains else None


def _ignored_chains(
    descriptor: Descriptor, is_ignored: Callable[[str], bool], above: tuple[str, ...]
) -> Iterator[tuple[str, ...]]:
    """The names that lead to each ignored field, through messages that do not repeat."""
    for field in descriptor.fields:
        chain = (*above, field.name)
        if is_ignored(".".join(chain)):
            yield chain
        elif field.message_type is not None and field.has_presence and len(chain) < _DEEPEST:
            yield from _ignored_chains(field.message_type, is_ignored, chain)


def _clear(message: ProtobufMessage, chain: tuple[str, ...]) -> None:
    for name in chain[:-1]:
        if not message.HasField(name):
            return
        message = getattr(message, name)
    message.ClearField(chain[-1])


def _parsed(kind: type[ProtobufMessage], payload: bytes) -> ProtobufMessage:
    try:
        return kind.FromString(payload)
    except DecodeError as error:
        raise UnreadableError(str(error)) from None


def _as_bytes(payload: bytes) -> Value:
    return {BYTES_FIELD: payload}


def _json(payload: bytes) -> Value:
    try:
        return json.loads(payload)
    except (ValueError, RecursionError) as error:
        raise UnreadableError(str(error)) from None


@lru_cache(maxsize=256)
def _message_class(descriptors: bytes, name: str) -> type[ProtobufMessage]:
    pool = DescriptorPool()
    try:
        for file in FileDescriptorSet.FromString(descriptors).file:
            pool.Add(file)
        return GetMessageClass(pool.FindMessageTypeByName(name))
    except (DecodeError, TypeError, KeyError, ValueError) as error:
        raise UnreadableError(str(error)) from None


def _fields(message: ProtobufMessage) -> dict[str, Value]:
    """Every field; of those that may be absent, the ones that are there."""
    descriptor: Descriptor = message.DESCRIPTOR  # type: ignore[assignment]  # one of two stubs
    return {
        field.name: _value(field, getattr(message, field.name))
        for field in descriptor.fields
        if not field.has_presence or message.HasField(field.name)
    }


def _value(field: FieldDescriptor, value: Any) -> Value:
    inner = field.message_type
    if inner is not None and inner.GetOptions().map_entry:
        return {str(key): _plain(value[key]) for key in sorted(value)}
    return _plain(value)


def _plain(value: Any) -> Value:
    if isinstance(value, ProtobufMessage):
        return _fields(value)
    if isinstance(value, bytes | str) or not hasattr(value, "__len__"):
        return value
    return [_plain(element) for element in value]


def _cdr(stream: Stream) -> Decode:
    store = ros2_store(stream.schema, stream.type_name)

    def decode(payload: bytes) -> Value:
        try:
            return _of_ros2(store.deserialize_cdr(payload, stream.type_name))
        except Exception as error:  # rosbags raises whatever its generated code meets
            raise UnreadableError(str(error) or type(error).__name__) from None

    return decode


@lru_cache(maxsize=256)
def ros2_store(definition: bytes, name: str) -> "Typestore":
    """The types of ROS 2 that a definition says.

    Raises:
        UnreadableError: it cannot be parsed.
        ImportError: the extra `ros2` is not installed.
    """
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    store = get_typestore(Stores.EMPTY)
    try:
        store.register(get_types_from_msg(definition.decode(), name))
    except Exception as error:  # a definition that it cannot parse
        raise UnreadableError(str(error)) from None
    return store


def _of_ros2(value: Any) -> Value:
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [_of_ros2(element) for element in value]
    names = getattr(value, "__dataclass_fields__", None)
    if names is None:
        return value
    return {name: _of_ros2(getattr(value, name)) for name in names if name != "__msgtype__"}
