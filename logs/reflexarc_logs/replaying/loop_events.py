"""What a loop did, as its log tells it: the messages that it got, its ticks, its keyframes."""

from collections.abc import Iterator
from typing import TypeAlias

from reflexarc_logs.container.rejected import accepted_message, rejected_message
from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_runtime.messages.topics import CONTROLS, KEYFRAME, REJECTED, SENSORS, TICK
from reflexarc_runtime.messages.wire import NO_SENDER, Message, Stamp
from reflexarc_runtime.messages_pb2 import Keyframe, Rejected, Tick

LoopEvent: TypeAlias = Message | Tick | Keyframe


def loop_events(log: Log) -> Iterator[LoopEvent]:
    """All that reached the loop's inbox, its ticks and its keyframes, in file order.

    What reached the loop and could not be decoded comes from the channel of rejected messages, in
    its place.

    Raises:
        LogError: the log cannot be read.
    """
    robot = log.run.robot
    keys = {topic.key(robot) for topic in (SENSORS[log.run.input], *CONTROLS)}
    tick, keyframe = log.topic(TICK.name), log.topic(KEYFRAME.name)
    rejected = log.topic(REJECTED.name)
    unnamed = NO_SENDER if log.names_senders else _usual_sender(log)
    for record in log.records(*(f"/{key}" for key in keys), tick, keyframe, rejected):
        if record.topic == tick:
            yield decode(log, record, Tick)
        elif record.topic == keyframe:
            yield decode(log, record, Keyframe)
        else:
            message = _message(log, record, record.topic == rejected, unnamed)
            if message.key in keys:
                yield message


def _usual_sender(log: Log) -> bytes:
    """Who sent the sensor's messages, where another tool dropped that: as a keyframe remembers."""
    for _, keyframe in log.messages(log.topic(KEYFRAME.name), Keyframe):
        if keyframe.HasField("newest"):
            return keyframe.newest.sender
    return NO_SENDER


def _message(log: Log, record: Record, was_rejected: bool, unnamed: bytes) -> Message:
    received_ns = record.log_ns - log.run.wall_offset_ns
    if was_rejected:
        return rejected_message(decode(log, record, Rejected), received_ns)
    sender = unnamed if record.sender == NO_SENDER else record.sender
    stamp = Stamp(record.sequence, record.publish_ns, sender)
    key = record.topic.removeprefix("/")
    return accepted_message(key, record.schema, record.payload, stamp, received_ns)
