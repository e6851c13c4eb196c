"""Messages as runtimes and bodies send them once a second, for whoever listens to a fleet."""

from typing import Any

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding

SECOND = 1_000_000_000
FIRST, SECOND_RUNTIME, BODY = b"\xa1" * 16, b"\xb2" * 16, b"\xc3" * 16


def status(
    robot: str = "robot0",
    sender: bytes = FIRST,
    at_s: float = 0.0,
    *,
    stamp_ns: int = 0,
    node: str = "runtime",
    **fields: Any,
) -> Message:
    payload = pb.Status(node=node, **fields).SerializeToString()
    return message(f"{robot}/status", payload, "reflexarc.Status", sender, at_s, stamp_ns)


def lease(robot: str = "robot0", sender: bytes = BODY, at_s: float = 0.0, **fields: Any) -> Message:
    payload = pb.Lease(**fields).SerializeToString()
    return message(f"{robot}/lease", payload, "reflexarc.Lease", sender, at_s)


def message(
    key: str,
    payload: bytes,
    schema: str,
    sender: bytes = FIRST,
    at_s: float = 0.0,
    stamp_ns: int = 0,
) -> Message:
    attachment = pack_stamp(Stamp(0, stamp_ns, sender))
    return Message(key, payload, protobuf_encoding(schema), attachment, round(at_s * SECOND))
