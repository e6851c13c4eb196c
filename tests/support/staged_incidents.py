"""Recorded drives in which something happens at known ticks."""

from collections.abc import Mapping
from pathlib import Path

from foxglove_schemas_protobuf.Log_pb2 import Log as FoxgloveLog
from google.protobuf.message import Message as ProtobufMessage
from mcap.reader import NonSeekingReader

from reflexarc_logs.container.writing import LogWriter
from reflexarc_runtime.messages.controls import encode_stop
from reflexarc_runtime.messages.topics import BODY, CONTACT, MARK, RESET, STOP, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Body, Contact, Reset, Tick
from support.recordings import MS, PERIOD_NS, START_NS

Staged = Mapping[int, tuple[Topic, ProtobufMessage]]
"""Index of a tick → what is heard behind it."""
NOWHEN: Mapping[int, int] = {}


def contact(count: int = 1) -> tuple[Topic, ProtobufMessage]:
    return CONTACT, Contact(count=count, x_m=1.25, y_m=-0.5)


def body() -> tuple[Topic, ProtobufMessage]:
    return BODY, Body(world="reflex", world_text="name = 'reflex'", seed=7, step_s=0.02)


def mark(text: str) -> tuple[Topic, ProtobufMessage]:
    return MARK, FoxgloveLog(message=text, name="mark")


def control_at(slot: int, topic: Topic, reason: str) -> Message:
    """A stop or a reset that arrives in front of the deadline of a slot."""
    payload = encode_stop(reason) if topic is STOP else Reset(reason=reason).SerializeToString()
    received_ns = START_NS + slot * PERIOD_NS - 2 * MS
    stamp = pack_stamp(Stamp(0, received_ns))
    return Message(
        topic.key("robot0"), payload, protobuf_encoding(topic.schema), stamp, received_ns
    )


def stopped_between(schedule: dict[int, list[Message]], first: int, end: int) -> None:
    """Stop a drive at one slot, and let it go on at another."""
    schedule[first] = [*schedule[first], control_at(first, STOP, "a hand")]
    schedule[end] = [*schedule[end], control_at(end, RESET, "go on")]


def staged(source: Path, out: Path, heard: Staged, sent_ns: Mapping[int, int] = NOWHEN) -> Path:
    """Copy a log, and put messages behind its ticks.

    `sent_ns` says when the message behind a tick was sent; by default, with the tick.
    """
    file = LogWriter(out)
    with source.open("rb") as stream:
        for record in NonSeekingReader(stream).iter_metadata():
            file.describe(record.name, record.metadata)
    with source.open("rb") as stream:
        for attachment in NonSeekingReader(stream).iter_attachments():
            file.attach(attachment.name, attachment.media_type, attachment.data)
    with source.open("rb") as stream:
        reader = NonSeekingReader(stream)
        for schema, channel, message in reader.iter_messages(log_time_order=False):
            where = file.raw_channel(
                channel.topic, channel.message_encoding, schema, channel.metadata
            )
            times = {"publish_ns": message.publish_time, "log_ns": message.log_time}
            file.add(where, message.data, sequence=message.sequence, **times)
            if schema.name == "reflexarc.Tick":
                index = Tick.FromString(message.data).decision.index
                if index in heard:
                    topic, said = heard[index]
                    beside = file.channel(f"/{topic.key('robot0')}", topic.message)
                    times["publish_ns"] = sent_ns.get(index, message.publish_time)
                    file.add(beside, said.SerializeToString(), sequence=index, **times)
    file.finish()
    return out
