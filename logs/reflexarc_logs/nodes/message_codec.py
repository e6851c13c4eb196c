"""From the payloads of a log to what a node is given, and from what it says back to payloads.

What it says becomes a payload of the recorded type before it is compared: a float32 is as rounded
as the recorded one, and what a dictionary leaves out is zero.
"""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_logs.container.packing.schemas import PROTOBUF, schema_of
from reflexarc_logs.diffing.message_file import Stream
from reflexarc_logs.diffing.payloads import UnreadableError, protobuf_class, ros2_store
from reflexarc_logs.nodes.node_class import NodeError
from reflexarc_logs.nodes.ros2_output import ros2_message, ros2_type_of


@dataclass(frozen=True)
class MessageCodec:
    """How the messages of a stream are read and written."""

    decode: Callable[[bytes], Any]
    encode: Callable[[Any], bytes]
    """Raises TypeError and ValueError where something is no such message."""


def codec_of(stream: Stream) -> MessageCodec:
    """The codec of a recorded stream.

    Raises:
        NodeError: of ROS 2, without the extra `ros2`.
    """
    if (kind := protobuf_class(stream)) is not None:
        return MessageCodec(kind.FromString, lambda said: _protobuf(kind, said))
    if stream.encoding == "json":
        return MessageCodec(json.loads, lambda said: json.dumps(_plain(said)).encode())
    if stream.encoding == "cdr" and stream.schema_encoding == "ros2msg":
        return _cdr(stream)
    return MessageCodec(bytes, _bytes)


def stream_for(topic: str, said: object, type_name: str = "") -> Stream:
    """The stream of a topic that was not recorded before.

    Args:
        topic: "/cmd_vel".
        said: the first message; an object says its type.
        type_name: of ROS 2, for a dictionary; empty: then it is written as JSON.

    Raises:
        NodeError: of a type of ROS 2 that is none of Jazzy's own.
    """
    if isinstance(said, ProtobufMessage):
        schema = schema_of(type(said))
        return Stream(topic, schema.name, PROTOBUF, PROTOBUF, schema.data)
    if type_name := ros2_type_of(said) or type_name:
        return Stream(topic, type_name, "cdr", "ros2msg", _definition(type_name))
    return Stream(topic, "", "json", "", b"")


def _cdr(stream: Stream) -> MessageCodec:
    name = stream.type_name
    try:
        store = ros2_store(stream.schema, name)
    except ImportError:
        raise NodeError(
            f"{stream.topic}: messages of ROS 2 need `pip install 'reflexarc[ros2]'`"
        ) from None
    except UnreadableError as error:
        raise NodeError(f"{stream.topic}: the definition of {name}: {error}") from None

    def encode(said: Any) -> bytes:
        if (other := ros2_type_of(said)) and other != name:
            raise TypeError(f"expected {name}, got {other}")
        return bytes(store.serialize_cdr(ros2_message(store, name, said), name))

    return MessageCodec(lambda payload: store.deserialize_cdr(payload, name), encode)


def _definition(type_name: str) -> bytes:
    from rosbags.typesys import Stores, get_typestore

    try:
        text, _ = get_typestore(Stores.ROS2_JAZZY).generate_msgdef(type_name, ros_version=2)
    except KeyError:
        raise NodeError(f"{type_name} is no type of ROS 2 Jazzy: record it once before") from None
    return text.encode()


def _protobuf(kind: type[ProtobufMessage], said: Any) -> bytes:
    wanted = kind.DESCRIPTOR.full_name
    if isinstance(said, ProtobufMessage):
        if said.DESCRIPTOR.full_name != wanted:
            raise TypeError(f"expected {wanted}, got {said.DESCRIPTOR.full_name}")
        return said.SerializeToString(deterministic=True)
    if not isinstance(said, Mapping):
        raise TypeError(f"expected {wanted} or a dictionary, got {type(said).__name__}")
    return kind(**_plain(said)).SerializeToString(deterministic=True)


def _bytes(said: Any) -> bytes:
    if not isinstance(said, bytes):
        raise TypeError(f"expected bytes, got {type(said).__name__}")
    return said


def _plain(said: Any) -> Any:
    """Arrays and numbers of NumPy as Python's own."""
    if isinstance(said, np.ndarray | np.generic):
        return said.tolist()
    if isinstance(said, Mapping):
        return {name: _plain(value) for name, value in said.items()}
    return [_plain(value) for value in said] if isinstance(said, list | tuple) else said
