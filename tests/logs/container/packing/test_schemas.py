"""Schemas without what a message does not need: the library decodes with them as before."""

import pytest
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.message import Message
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory
from mcap_protobuf.schema import build_file_descriptor_set

from reflexarc_logs.container.packing.schemas import schema_of
from reflexarc_runtime.messages.topics import TOPICS
from reflexarc_runtime.messages_pb2 import Keyframe, Stop, Tick

KINDS = sorted({topic.message for topic in TOPICS}, key=lambda kind: kind.DESCRIPTOR.full_name)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.DESCRIPTOR.full_name)
def test_the_library_decodes_every_message_as_with_the_whole_files(kind: type[Message]):
    payload = filled(kind()).SerializeToString()
    whole = build_file_descriptor_set(kind).SerializeToString()
    texts = [decoded(schema_of(kind).data, kind, payload), decoded(whole, kind, payload)]
    assert texts[0] == texts[1] != ""


def test_what_a_message_does_not_need_is_left_out():
    assert names(Stop) == {"Stop"}
    assert names(Tick) == {"Tick", "Decision", "Input", "Command", "Timing", "Verdict"}
    assert {"Keyframe", "AcceptedScan", "LeastDelay"} <= names(Keyframe)
    assert "ArrowPrimitive" in names(SceneUpdate)


def names(kind: type[Message]) -> set[str]:
    files = FileDescriptorSet.FromString(schema_of(kind).data).file
    return {part.name for file in files for part in (*file.message_type, *file.enum_type)}


def decoded(descriptors: bytes, kind: type[Message], payload: bytes) -> str:
    schema = Schema(1, descriptors, "protobuf", kind.DESCRIPTOR.full_name)
    decode = DecoderFactory().decoder_for("protobuf", schema)
    assert decode is not None
    return str(decode(payload))


def filled(message: Message, depth: int = 0) -> Message:
    """A message with something in each of its fields, and in theirs."""
    for field in message.DESCRIPTOR.fields:
        if field.message_type is None:
            value = {9: "text", 12: b"bytes", 8: True}.get(field.type, 1)
            held = getattr(message, field.name)
            if hasattr(held, "append"):
                held.append(value)
            else:
                setattr(message, field.name, value)
        elif depth < 6 and not field.message_type.GetOptions().map_entry:
            held = getattr(message, field.name)
            filled(held.add() if hasattr(held, "add") else held, depth + 1)
    return message
