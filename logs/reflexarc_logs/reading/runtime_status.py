"""What a runtime says of itself in a log, for recordings that know nothing else of it."""

from google.protobuf.message import DecodeError

from reflexarc_logs.container.run_info import PACES
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import RUNTIME_NODE


def runtime_status(payload: bytes) -> pb.Status | None:
    """The status of a runtime; None: it is anybody else's, or none."""
    try:
        status = pb.Status.FromString(payload)
    except DecodeError:
        return None
    return status if status.node == RUNTIME_NODE else None


def named_pace(status: pb.Status) -> str:
    """When its ticks begin; empty if it says nothing that we know."""
    return status.pace if status.pace in PACES else ""
