"""What a loop did, as its log tells it: the messages that it got, its ticks, its keyframes."""

from collections.abc import Iterator
from typing import TypeAlias

from reflexarc_logs.container.rejected import accepted_message, rejected_message
from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.topics import CONTROLS, KEYFRAME, REJECTED, SENSORS, TICK, Topic
from reflexarc_runtime.messages.wire import NO_SENDER, Message, Stamp
from reflexarc_runtime.messages_pb2 import Keyframe, Rejected, Tick

LoopEvent: TypeAlias = Message | Tick | Keyframe

_MOST_NS = (1 << 63) - 1
"""The latest time that a loop's clock and the bus can name; a log's own times go to 2^64."""


class NoLoopError(LogError):
    """A log does not hold what one loop received and decided.

    Args:
        log: the log.
        reason: what is wrong with it.
    """

    def __init__(self, log: Log, reason: str) -> None:
        super().__init__(f"{log.path}: no replay at level node: {reason}; use --level policy")
        self.reason = reason


def loop_events(log: Log) -> Iterator[LoopEvent]:
    """All that reached the loop's inbox, its ticks and its keyframes, in file order.

    What reached the loop and could not be decoded comes from the channel of rejected messages, in
    its place.

    Raises:
        LogError: the log cannot be read.
        NoLoopError: a message of a time that no loop can have met.
    """
    robot = log.run.robot
    keys = {topic.key(robot) for topic in (SENSORS[log.run.input], *beside_the_sensor(log))}
    tick, keyframe = log.topic(TICK.name), log.topic(KEYFRAME.name)
    rejected = log.topic(REJECTED.name)
    unnamed = {} if log.names_senders else _usual_senders(log)
    for record in log.records(*(f"/{key}" for key in keys), tick, keyframe, rejected):
        if record.topic == tick:
            yield decode(log, record, Tick)
        elif record.topic == keyframe:
            yield decode(log, record, Keyframe)
        else:
            usual = unnamed.get(record.topic, NO_SENDER)
            message = _message(log, record, record.topic == rejected, usual)
            if message.key in keys:
                yield message


def beside_the_sensor(log: Log) -> tuple[Topic, ...]:
    """The topics that reached the loop beside the one on which it decided.

    Raises:
        LogError: the settings of the log's guard are none.
    """
    ranges = GuardSettings.from_json(log.run.guard).ranges if log.run.guard else ""
    return (*CONTROLS, SENSORS[ranges]) if ranges else CONTROLS


def _usual_senders(log: Log) -> dict[str, bytes]:
    """Who sent on each topic, where another tool dropped that: as keyframes remember."""
    usual: dict[str, bytes] = {}
    ranges = [log.topic(topic.name) for topic in beside_the_sensor(log) if topic not in CONTROLS]
    for _, keyframe in log.messages(log.topic(KEYFRAME.name), Keyframe):
        if keyframe.HasField("newest"):
            usual.setdefault(log.topic(SENSORS[log.run.input].name), keyframe.newest.sender)
        for topic in ranges if keyframe.HasField("ranges") else ():
            usual.setdefault(topic, keyframe.ranges.sender)
        if len(usual) > len(ranges):
            break
    return usual


def _message(log: Log, record: Record, was_rejected: bool, unnamed: bytes) -> Message:
    received_ns = record.log_ns - log.run.wall_offset_ns
    if max(record.publish_ns, abs(received_ns)) > _MOST_NS:
        latest = max(record.publish_ns, record.log_ns)
        raise NoLoopError(log, f"a message of the time {latest} ns, which no loop can have met")
    if was_rejected:
        return rejected_message(decode(log, record, Rejected), received_ns)
    sender = unnamed if record.sender == NO_SENDER else record.sender
    stamp = Stamp(record.sequence, record.publish_ns, sender)
    key = record.topic.removeprefix("/")
    return accepted_message(key, record.schema, record.payload, stamp, received_ns)
