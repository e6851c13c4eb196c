"""Rewrites a log with valid CRCs: what an honest tool, or a forger, could have written."""

from collections.abc import Callable, Mapping
from pathlib import Path

from google.protobuf.descriptor_pb2 import DescriptorProto, FileDescriptorSet
from mcap.records import Attachment, Channel, DataEnd, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from reflexarc_runtime.messages_pb2 import Decision, Tick

Edit = Callable[[str, int, bytes], bytes | None]
"""(topic, how many messages of it came before, payload) → payload, or None to leave it out."""


def unchanged(topic: str, nth: int, payload: bytes) -> bytes | None:
    return payload


def rewrite(
    source: Path,
    target: Path,
    edit: Edit = unchanged,
    *,
    metadata: Mapping[str, Mapping[str, str]] | None = None,
    attachments: Mapping[str, bytes | None] | None = None,
    schema: Callable[[Schema], bytes] = lambda schema: schema.data,
    compression: bool = True,
) -> Path:
    """Copy a log with changes: fields of metadata, attachments, payloads, schemas."""
    new_metadata, new_attachments = dict(metadata or {}), dict(attachments or {})
    with source.open("rb") as file, target.open("wb") as out:
        writer = Writer(out, chunk_size=8192, enable_data_crcs=True, use_chunking=compression)
        writer.start(profile="reflexarc")
        schemas: dict[int, int] = {}
        channels: dict[int, tuple[int, str]] = {}
        counts: dict[str, int] = {}
        for record in StreamReader(file).records:
            match record:
                case DataEnd():
                    break
                case Metadata():
                    changes = new_metadata.pop(record.name, {})
                    writer.add_metadata(record.name, {**record.metadata, **changes})
                case Attachment():
                    data = new_attachments.get(record.name, record.data)
                    if data is not None:
                        writer.add_attachment(0, 0, record.name, record.media_type, data)
                case Schema():
                    data = schema(record)
                    schemas[record.id] = writer.register_schema(record.name, record.encoding, data)
                case Channel():
                    schema_id, sender = schemas[record.schema_id], record.metadata
                    new = writer.register_channel(
                        record.topic, record.message_encoding, schema_id, sender
                    )
                    channels[record.id] = new, record.topic
                case Message():
                    channel, topic = channels[record.channel_id]
                    nth = counts[topic] = counts.get(topic, -1) + 1
                    payload = edit(topic, nth, record.data)
                    if payload is not None:
                        writer.add_message(
                            channel, record.log_time, payload, record.publish_time, record.sequence
                        )
        for name, document in new_metadata.items():
            writer.add_metadata(name, dict(document))
        writer.finish()
    return target


def edit_decisions(change: Callable[[Decision], None]) -> Edit:
    """An edit that changes the decision in every tick."""

    def edit(topic: str, nth: int, payload: bytes) -> bytes:
        if not topic.endswith("/tick"):
            return payload
        tick = Tick.FromString(payload)
        change(tick.decision)
        return tick.SerializeToString()

    return edit


def edit_decision_schema(change: Callable[[DescriptorProto], None]) -> Callable[[Schema], bytes]:
    """A change of the descriptor of `reflexarc.Decision` wherever a log carries it."""

    def edit(schema: Schema) -> bytes:
        files = FileDescriptorSet.FromString(schema.data)
        for file in files.file:
            for message in file.message_type:
                if file.package == "reflexarc" and message.name == "Decision":
                    change(message)
        return files.SerializeToString()

    return edit


def flip_bit(data: bytes, position: int, bit: int = 0) -> bytes:
    """The same bytes with one bit changed."""
    changed = bytearray(data)
    changed[position] ^= 1 << bit
    return bytes(changed)
