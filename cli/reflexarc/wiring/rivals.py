"""Tells a runtime that its body obeys another: two that command one robot are a mistake.

A body says ten times a second who holds its lease. Whoever starts a second runtime with the same
`--robot` would otherwise see one that runs, decides, and moves nothing.
"""

from collections.abc import Callable

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.wire import Message

LOOK_AGAIN_NS = 500_000_000
"""Whatever is sent, and by whom, no more than two a second are looked at."""
SEEN = 3
"""Times in a row; less is a lease that is being handed over."""
_MOST_TOLD = 4
_SHOWN_HASH = 8


class Rivals:
    """Looks at who holds a body's lease, and says so when it is somebody else.

    Args:
        own: the identifier that the runtime's commands carry.
        say: takes a line.
        robot: the robot that both command.
    """

    def __init__(self, own: bytes, say: Callable[[str], None], robot: str) -> None:
        self._own, self._say, self._robot = own, say, robot
        self._looked_ns = -LOOK_AGAIN_NS
        self._holder, self._times = b"", 0
        self._told: set[bytes] = set()

    def hear(self, message: Message) -> None:
        """Take one message of the body's lease; called on a thread of the bus."""
        if message.received_ns - self._looked_ns < LOOK_AGAIN_NS:
            return
        self._looked_ns = message.received_ns
        try:
            holder = pb.Lease.FromString(message.payload).holder
        except DecodeError:
            return
        self._times = self._times + 1 if holder == self._holder else 1
        self._holder = holder
        is_other = holder not in (b"", self._own)
        if is_other and self._times >= SEEN and len(self._told - {holder}) < _MOST_TOLD:
            self._tell(holder)

    def _tell(self, holder: bytes) -> None:
        if holder in self._told:
            return
        self._told.add(holder)
        self._say(
            f"{self._robot} obeys another runtime, {holder.hex()[:_SHOWN_HASH]}, and not this one; "
            "end one of the two, or name another --robot"
        )
