"""A message on the bus: key, payload, encoding, and an attachment with its number and time.

The attachment has the 33 bytes of rmw_zenoh: sequence (int64), source time (int64 ns), length of
the identifier (uint8, 16) and the sender's identifier, little-endian.
"""

import struct
from dataclasses import dataclass, replace

MAX_PAYLOAD_BYTES = 1 << 20
TOO_LARGE = bytes(MAX_PAYLOAD_BYTES + 1)
"""Stands for every payload that is larger, which is not even copied: all are refused alike."""
MAX_ATTACHMENT_BYTES = 1024
"""What is kept of an attachment: far more than one has."""
MAX_ENCODING_CHARACTERS = 256
MAX_SEQUENCE = (1 << 32) - 1
"""The largest sequence number that a log can keep, in 32 bits."""

SENDER_BYTES = 16
NO_SENDER = bytes(SENDER_BYTES)
"""The identifier of whoever gives none."""

_ATTACHMENT = struct.Struct("<qqB16s")


class UndecodableError(ValueError):
    """A message that cannot be decoded; it is recorded on `rejected`."""


class UnfitError(ValueError):
    """A message that was decoded and does not fit the contract."""


@dataclass(frozen=True, slots=True)
class Message:
    """One message as it came from the bus."""

    key: str
    payload: bytes
    encoding: str
    attachment: bytes
    """Empty where there was none."""
    received_ns: int
    """On the receiver's monotonic clock."""


@dataclass(frozen=True, slots=True)
class Stamp:
    """Sequence number of a message, when it was sent on the sender's clock, and by whom."""

    sequence: int
    time_ns: int
    sender: bytes = NO_SENDER
    """16 bytes that a node draws when it begins; in lockstep the same ones in every run."""


def protobuf_encoding(schema: str) -> str:
    """Encoding of a protobuf payload as Zenoh spells it."""
    return f"application/protobuf;{schema}"


def lockstep_sender(node: str) -> bytes:
    """The identifier of a node in lockstep, where the same run gives the same log."""
    return f"lockstep {node}".encode()[:SENDER_BYTES].ljust(SENDER_BYTES, b"\0")


def pack_stamp(stamp: Stamp) -> bytes:
    """A stamp as an attachment."""
    return _ATTACHMENT.pack(stamp.sequence, stamp.time_ns, len(stamp.sender), stamp.sender)


def unpack_stamp(attachment: bytes) -> Stamp:
    """Read an attachment.

    Raises:
        UndecodableError: it is missing, of another size, or holds numbers that no log can keep.
    """
    if len(attachment) != _ATTACHMENT.size:
        # No exact size of what is far too long: a log keeps only its head, and must say the same.
        got = len(attachment) if len(attachment) <= 2 * _ATTACHMENT.size else "more"
        raise UndecodableError(
            f"attachment: expected {_ATTACHMENT.size} bytes (sequence, time, sender), got {got}"
        )
    sequence, time_ns, _, sender = _ATTACHMENT.unpack(attachment)
    if not 0 <= sequence <= MAX_SEQUENCE or time_ns < 0:
        raise UndecodableError(
            f"attachment: expected sequence 0 to 2^32 − 1 and time ≥ 0, got {sequence}, {time_ns}"
        )
    return Stamp(sequence, time_ns, sender)


def at_source_time(message: Message, earliest_ns: int = 0) -> Message:
    """The message as if it had arrived when it was sent, which lockstep takes for the time.

    Without a readable stamp, or with one before `earliest_ns`, it arrives at `earliest_ns`.
    """
    try:
        time_ns = unpack_stamp(message.attachment).time_ns
    except UndecodableError:
        time_ns = earliest_ns
    return replace(message, received_ns=max(time_ns, earliest_ns))


def check_encoding(message: Message, schema: str) -> None:
    """Check the encoding that a message declares, and its size.

    Raises:
        UndecodableError: another encoding or schema, or a payload beyond 1 MiB.
    """
    expected = protobuf_encoding(schema)
    if message.encoding != expected:
        raise UndecodableError(f"encoding: expected {expected}, got {message.encoding[:80]!r}")
    if len(message.payload) > MAX_PAYLOAD_BYTES:
        raise UndecodableError("payload: expected at most 1 MiB, got more")
