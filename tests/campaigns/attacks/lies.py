"""Commands that a stranger may put on the bus, as data: each is a lie in one respect.

A stranger reads the bus: it knows the body's identifier and the times of its retinas.
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import COMMAND
from reflexarc_runtime.messages.wire import NO_SENDER, Stamp, pack_stamp, protobuf_encoding

STRANGER = b"a stranger......"
HOUR_NS = 3600 * 10**9
LONGEST_NS = 2**63 - 1
PROPER = protobuf_encoding(COMMAND.schema)


@dataclass(frozen=True)
class Spoken:
    """What is put on the bus."""

    payload: bytes
    attachment: bytes = pack_stamp(Stamp(0, 0, STRANGER))
    encoding: str = PROPER
    robot: str = "robot0"


Lie = Callable[[Stamp], Spoken]
"""From the stamp of the body's last retina to a message."""


def command(stamp: Stamp, **changes: Any) -> bytes:
    """A command that is in order in every respect, but for these changes."""
    fields: dict[str, Any] = {
        "verdict": pb.OK,
        "linear_mps": 1.0,
        "valid_for_ns": 10**9,
        "source_sequence": stamp.sequence,
        "source_time_ns": stamp.time_ns,
        "body": stamp.sender,
    }
    return pb.Command(**fields | changes).SerializeToString()


def anonymous() -> bytes:
    """Of the time 0, valid for ever, to nobody."""
    return command(Stamp(0, 0, b""), valid_for_ns=LONGEST_NS)


def _with(**changes: Any) -> Lie:
    return lambda stamp: Spoken(command(stamp, **changes))


def _attached(attachment: bytes) -> Lie:
    return lambda stamp: Spoken(command(stamp), attachment)


LIES: dict[str, Lie] = {
    "of time 0, valid for 2⁶³−1 ns, without attachment": lambda _: Spoken(anonymous(), b""),
    "the same as text/plain": lambda _: Spoken(anonymous(), b"", "text/plain"),
    "the same with a sender": lambda _: Spoken(anonymous()),
    "in order, but text/plain": lambda s: Spoken(command(s), encoding="text/plain"),
    "in order, without attachment": _attached(b""),
    "in order, attachment of 32 bytes": _attached(bytes(32)),
    "in order, sender of zeros": _attached(pack_stamp(Stamp(0, 0, NO_SENDER))),
    "in order, attachment's sequence 2⁶³−1": _attached(
        struct.pack("<qqB16s", LONGEST_NS, 0, 16, STRANGER)
    ),
    "in order, attachment's time −1": _attached(struct.pack("<qqB16s", 0, -1, 16, STRANGER)),
    "validity −1 ns": _with(valid_for_ns=-1),
    "validity −2⁶³ ns": _with(valid_for_ns=-(2**63)),
    "validity 0": _with(valid_for_ns=0),
    "speed NaN": _with(linear_mps=math.nan),
    "speed +∞": _with(linear_mps=math.inf),
    "turn −∞": _with(angular_radps=-math.inf),
    "of a time in one second": lambda s: Spoken(command(s, source_time_ns=s.time_ns + 10**9)),
    "of the time 2⁶³−1": _with(source_time_ns=LONGEST_NS),
    "of the time −2⁶³, valid for 2⁶³−1 ns": _with(source_time_ns=-(2**63), valid_for_ns=LONGEST_NS),
    "an hour old, valid for a second": lambda s: Spoken(
        command(s, source_time_ns=s.time_ns - HOUR_NS)
    ),
    "for another body": _with(body=b"another body...."),
    "for a body of zeros": _with(body=bytes(16)),
    "on the key of another robot": lambda s: Spoken(command(s), robot="robot1"),
    "a verdict that is none": _with(verdict=99),
    "a verdict that is missing": _with(verdict=0),
    "safe, with a speed of 5 m/s": lambda _: Spoken(
        pb.Command(action=-1, verdict=pb.STOPPED, linear_mps=5.0).SerializeToString()
    ),
    "empty": lambda _: Spoken(b""),
    "garbage": lambda _: Spoken(b"\xff" * 100),
    "2 MiB": lambda s: Spoken(command(s) + bytes(2 << 20)),
}
