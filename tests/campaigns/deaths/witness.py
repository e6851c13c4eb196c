"""What a body says: whom it obeys, whether it is armed, and where it stands."""

from dataclasses import dataclass, field

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import LEASE
from reflexarc_runtime.messages.wire import Message

Place = tuple[float, float]


@dataclass(frozen=True)
class Holder:
    """A runtime that a body began to obey."""

    since_s: float
    identifier: bytes
    armed: bool
    """Whether the body was armed at that moment."""


@dataclass
class Witness:
    """Hears a body; `holders` and `places` only grow."""

    holders: list[Holder] = field(default_factory=list)
    places: list[tuple[float, Place]] = field(default_factory=list)
    """When it was where, m."""
    armed: bool = False
    state: str = ""

    def hear(self, message: Message) -> None:
        """Take one message of a body's."""
        now_s = message.received_ns * 1e-9
        if message.key.endswith(LEASE.name):
            self._hear_lease(pb.Lease.FromString(message.payload), now_s)
        else:
            position = PoseInFrame.FromString(message.payload).pose.position
            self.places.append((now_s, (position.x, position.y)))

    def _hear_lease(self, lease: pb.Lease, now_s: float) -> None:
        newest = self.holders[-1].identifier if self.holders else b""
        if lease.holder and lease.holder != newest:
            self.holders.append(Holder(now_s, lease.holder, lease.armed))
        self.armed, self.state = lease.armed, lease.state

    def rolled_m(self, since_s: float, until_s: float) -> float:
        """How far it was from where it was first in that time, at most."""
        places = [place for at_s, place in tuple(self.places) if since_s <= at_s <= until_s]
        return max((abs(x - places[0][0]) + abs(y - places[0][1]) for x, y in places), default=0.0)
