"""Decides which messages a log holds on their own channel, and which on `<robot>/rejected`.

The test is the one that the controller's senses apply: key, encoding, size, stamp, protobuf. So
every viewer can read the proper channels, and replay can restore the stream as it arrived. A topic
has one channel for each sender, up to 16 of them: who sent a message is in the log.
"""

import struct
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_runtime.errors import LogError
from reflexarc_runtime.keyframe import Keyframe, encode_state
from reflexarc_runtime.messages.codec import SCHEMAS
from reflexarc_runtime.messages.topics import CONTROLS, KEYFRAME, ON_THE_BUS, REJECTED, Topic
from reflexarc_runtime.messages.wire import (
    MAX_PAYLOAD_BYTES,
    NO_SENDER,
    Message,
    Stamp,
    UndecodableError,
    check_encoding,
    pack_stamp,
    protobuf_encoding,
    unpack_stamp,
)
from reflexarc_runtime.messages_pb2 import Rejected

KEPT_BYTES = 64 * 1024
"""How much of a rejected payload a log keeps, if it is rejected for what it is."""
MAX_SENDERS = 16
"""Senders of one topic that have channels of their own; a crowd beyond that is no robot."""


class CrowdedError(UndecodableError):
    """A good message of one sender too many."""


@dataclass(frozen=True, slots=True)
class LogEntry:
    """One message as it is written to a log."""

    key: str
    kind: type[ProtobufMessage]
    payload: bytes
    sequence: int
    sent_ns: int | None
    """Source time; None if the message has no valid time stamp."""
    received_ns: int
    sender: bytes = NO_SENDER


class Intake:
    """Sorts the messages of one robot into accepted and rejected ones, and encodes keyframes."""

    def __init__(self, robot: str) -> None:
        self._topics = dict(_recorded(robot))
        self._controls = {topic.key(robot) for topic in CONTROLS}
        """What comes on these keys decides even if it cannot be decoded: it is kept whole."""
        self._rejected_key = REJECTED.key(robot)
        self._rejected = 0
        self._keyframe_key = KEYFRAME.key(robot)
        self._senders: dict[str, set[bytes]] = defaultdict(set)

    def sort(self, entry: Message | Keyframe) -> LogEntry:
        """A message on its own channel, or wrapped for the channel of rejected ones; a keyframe."""
        if isinstance(entry, Keyframe):
            return self._encode(entry)
        try:
            return self._accept(entry)
        except CrowdedError as error:
            return self._reject(entry, str(error), MAX_PAYLOAD_BYTES)
        except UndecodableError as error:
            kept = MAX_PAYLOAD_BYTES if entry.key in self._controls else KEPT_BYTES
            return self._reject(entry, str(error), kept)

    def _encode(self, keyframe: Keyframe) -> LogEntry:
        state, at_ns = keyframe.state, keyframe.received_ns
        payload = encode_state(state, keyframe.policy_hash)
        sender = keyframe.sender
        return LogEntry(
            self._keyframe_key, KEYFRAME.message, payload, state.index, at_ns, at_ns, sender
        )

    def _accept(self, message: Message) -> LogEntry:
        topic = self._topics.get(message.key)
        if topic is None:
            raise UndecodableError("key: not one of this robot's recorded topics")
        check_encoding(message, topic.schema)
        stamp = unpack_stamp(message.attachment)
        kind = SCHEMAS[topic.schema]
        try:
            kind.FromString(message.payload)
        except DecodeError:
            raise UndecodableError(f"payload: no {topic.schema}") from None
        self._admit(message.key, stamp.sender)
        return LogEntry(
            key=message.key,
            kind=kind,
            payload=message.payload,
            sequence=stamp.sequence,
            sent_ns=stamp.time_ns,
            received_ns=message.received_ns,
            sender=stamp.sender,
        )

    def _admit(self, key: str, sender: bytes) -> None:
        known = self._senders[key]
        if sender not in known and len(known) >= MAX_SENDERS:
            raise CrowdedError(f"sender: more than {MAX_SENDERS} on this topic")
        known.add(sender)

    def _reject(self, message: Message, reason: str, kept_bytes: int) -> LogEntry:
        wrapped = Rejected(
            key=message.key,
            encoding=message.encoding,
            payload=message.payload[:kept_bytes],
            attachment=message.attachment[:KEPT_BYTES],
            reason=reason,
            payload_bytes=len(message.payload),
        )
        sequence, self._rejected = self._rejected, self._rejected + 1
        payload = wrapped.SerializeToString()
        return LogEntry(self._rejected_key, Rejected, payload, sequence, None, message.received_ns)


def accepted_message(
    key: str, schema: str, payload: bytes, stamp: Stamp, received_ns: int
) -> Message:
    """Restore an accepted message as it came from the bus.

    Raises:
        LogError: its stamp is none that a message on the bus can have; times there are signed.
    """
    try:
        attachment = pack_stamp(stamp)
    except struct.error:
        raise LogError(
            f"/{key}: a message sent at {stamp.time_ns} ns: expected a time below 2^63 ns"
        ) from None
    return Message(key, payload, protobuf_encoding(schema), attachment, received_ns)


def rejected_message(rejected: Rejected, received_ns: int) -> Message:
    """Restore a rejected message, or make one that is rejected for the same reason.

    A payload that was cut becomes zeros of the same size: zeros are never protobuf, whereas the
    part that was kept might be.
    """
    payload = rejected.payload
    if rejected.payload_bytes > len(payload):
        payload = bytes(min(rejected.payload_bytes, MAX_PAYLOAD_BYTES + 1))
    return Message(rejected.key, payload, rejected.encoding, rejected.attachment, received_ns)


def _recorded(robot: str) -> Iterator[tuple[str, Topic]]:
    """The topics that are recorded as they are, by key; only the recorder writes `rejected`."""
    for topic in ON_THE_BUS:
        yield topic.key(robot), topic
