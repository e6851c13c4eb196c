"""Messages for the gate of a body, as a runtime, an operator or a stranger sends them."""

from typing import Any

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import COMMAND, HOLD_TO_RUN, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding

MS = 1_000_000
BODY = b"body............"
ONE, OTHER, OPERATOR = b"one runtime.....", b"other runtime...", b"operator........"


def message(
    topic: Topic, payload: bytes = b"", sender: bytes | None = OPERATOR, **fields: Any
) -> Message:
    """A message of a topic; `sender` None: without an attachment."""
    attachment = b"" if sender is None else pack_stamp(Stamp(0, 0, sender))
    given: dict[str, Any] = {
        "key": topic.key("robot0"),
        "payload": payload,
        "encoding": protobuf_encoding(topic.schema),
        "attachment": attachment,
        "received_ns": 0,
    }
    return Message(**given | fields)


def drive(
    source_ns: int,
    sender: bytes | None = ONE,
    linear_mps: float = 1.0,
    valid_for_ns: int = 100 * MS,
    body: bytes = BODY,
    **fields: Any,
) -> Message:
    """A command that drives, for an input of `source_ns`."""
    command = pb.Command(
        verdict=pb.OK,
        linear_mps=linear_mps,
        valid_for_ns=valid_for_ns,
        source_sequence=1,
        source_time_ns=source_ns,
        body=body,
    )
    for name in ("lateral_mps", "angular_radps"):
        setattr(command, name, fields.pop(name, 0.0))
    payload = fields.pop("payload", command.SerializeToString())
    return message(COMMAND, payload, sender, **fields)


def hold(
    source_ns: int,
    pressed_ns: int = 0,
    sender: bytes | None = OPERATOR,
    *,
    held: bool = True,
    body: bytes = BODY,
    **fields: Any,
) -> Message:
    """A button that is held, or that was let go, as its holder says it."""
    said = pb.HoldToRun(held=held, body=body, source_time_ns=source_ns, pressed_time_ns=pressed_ns)
    return message(HOLD_TO_RUN, said.SerializeToString(), sender, **fields)


def safe(sender: bytes | None = ONE, linear_mps: float = 0.0) -> Message:
    """A safe command, whatever speeds it names."""
    command = pb.Command(action=-1, verdict=pb.NO_INPUT, linear_mps=linear_mps)
    return message(COMMAND, command.SerializeToString(), sender)
