"""The messages that stop a loop, and that let it drive again."""

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import RESET, SWAP
from reflexarc_runtime.messages.wire import (
    MAX_PAYLOAD_BYTES,
    Message,
    UndecodableError,
    check_encoding,
)

_NO_REASON = "a stop without a reason"
_QUOTED = 80
"""Characters of a reason that every tick repeats until the reset."""


def encode_stop(reason: str) -> bytes:
    """`reflexarc.Stop`."""
    return pb.Stop(reason=reason).SerializeToString()


def encode_own_release(reason: str) -> bytes:
    """`reflexarc.Release` of a runtime that gives its own lease back, and nobody else's."""
    return pb.Release(reason=reason, own=True).SerializeToString()


def stop_reason(message: Message) -> str:
    """Why to stop. Whatever comes on this key stops, even if it cannot be read."""
    if len(message.payload) > MAX_PAYLOAD_BYTES:
        return _NO_REASON
    try:
        reason = pb.Stop.FromString(message.payload).reason[:_QUOTED]
    except DecodeError:
        reason = ""
    return reason or _NO_REASON


def lateness_of(message: Message) -> str:
    """What the watchdog said of a late tick, in words."""
    try:
        late_ns = pb.Overrun.FromString(message.payload).late_ns
    except DecodeError:
        return "a tick was late"
    return f"a tick was late by {late_ns / 1e6:.0f} ms"


def encode_overrun(since_ns: int, late_ns: int, ended_policy: str = "") -> bytes:
    """`reflexarc.Overrun`."""
    return pb.Overrun(
        since_ns=since_ns, late_ns=late_ns, ended_policy=ended_policy
    ).SerializeToString()


def ended_policy_of(message: Message) -> str:
    """The hash of the policy whose decision was ended, by an overrun; empty if none was."""
    try:
        return pb.Overrun.FromString(message.payload).ended_policy
    except DecodeError:
        return ""


def is_reset(message: Message) -> bool:
    """Whether it is a reset: unlike a stop, it counts only if it is what it should be."""
    try:
        check_encoding(message, RESET.schema)
        pb.Reset.FromString(message.payload)
    except (UndecodableError, DecodeError):
        return False
    return True


def encode_swap(policy: bytes, policy_hash: str, reason: str, *, while_moving: bool) -> bytes:
    """`reflexarc.Swap`."""
    return pb.Swap(
        policy=policy, policy_hash=policy_hash, reason=reason, while_moving=while_moving
    ).SerializeToString()


def swap_of(message: Message) -> pb.Swap | None:
    """The swap in a message; None if it is none."""
    try:
        check_encoding(message, SWAP.schema)
        return pb.Swap.FromString(message.payload)
    except (UndecodableError, DecodeError):
        return None
