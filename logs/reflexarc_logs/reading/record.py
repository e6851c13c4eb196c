"""One message as a log holds it."""

from typing import NamedTuple

from reflexarc_runtime.messages.wire import NO_SENDER


class Record(NamedTuple):
    """One message as the log holds it. Times in nanoseconds."""

    topic: str
    """With a leading slash: "/robot0/retina"."""
    schema: str
    """Full name of the protobuf message."""
    sequence: int
    log_ns: int
    """Arrival: the recorder's monotonic clock plus `RunInfo.wall_offset_ns`."""
    publish_ns: int
    """On the sender's clock."""
    payload: bytes
    sender: bytes = NO_SENDER
    """Who sent it: 16 bytes; zeros in logs that do not say."""
