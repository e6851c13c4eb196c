"""What a message to a body says, if it is in order: encoding, attachment, content."""

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Command
from reflexarc_runtime.messages.codec import decode_command
from reflexarc_runtime.messages.topics import COMMAND, HOLD_TO_RUN, Topic
from reflexarc_runtime.messages.wire import (
    NO_SENDER,
    Message,
    UndecodableError,
    check_encoding,
    unpack_stamp,
)
from reflexarc_sim_bridge.body.gate.hold import Grip
from reflexarc_sim_bridge.body.gate.refusal import Refusal


def read_command(message: Message) -> tuple[bytes, Command] | Refusal:
    """The sender and the command; or why it cannot be believed."""
    try:
        check_encoding(message, COMMAND.schema)
    except UndecodableError:
        return Refusal.ENCODING
    sender = _sender_of(message)
    if sender is None:
        return Refusal.UNSIGNED
    command = decode_command(message.payload)
    return Refusal.UNREADABLE if command is None else (sender, command)


def read_grip(message: Message) -> Grip | Refusal:
    """What is said of a button; or why it cannot be believed."""
    refusal = fault_of_operator(HOLD_TO_RUN, message)
    sender = _sender_of(message)
    if refusal is not None or sender is None:
        return refusal or Refusal.UNSIGNED
    hold = pb.HoldToRun.FromString(message.payload)
    return Grip(sender, hold.held, hold.body, hold.source_time_ns, hold.pressed_time_ns)


def fault_of_operator(topic: Topic, message: Message) -> Refusal | None:
    """Why an operator's message does not count: unlike a stop, it must be in order."""
    try:
        check_encoding(message, topic.schema)
        topic.message.FromString(message.payload)
    except UndecodableError:
        return Refusal.ENCODING
    except DecodeError:
        return Refusal.UNREADABLE
    return Refusal.UNSIGNED if _sender_of(message) is None else None


def gives_back_other(message: Message, holder: bytes) -> bool:
    """Whether a release in order is that of a runtime's own lease, which it does not have."""
    return pb.Release.FromString(message.payload).own and _sender_of(message) != holder


def _sender_of(message: Message) -> bytes | None:
    try:
        sender = unpack_stamp(message.attachment).sender
    except UndecodableError:
        return None
    return None if sender == NO_SENDER else sender
