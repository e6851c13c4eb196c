"""What a body says of its gate on `<robot>/lease`: whom it obeys, what it refused, and why."""

from dataclasses import dataclass

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_sim_bridge.body.gate.lease import Lease

SAID_EVERY_NS = 100_000_000
"""Time between two of them at most: whoever holds a button repeats their times."""


@dataclass(frozen=True, slots=True)
class Account:
    """Whom a body obeys and what it refused: what it says on `<robot>/lease`."""

    lease: Lease
    armed: bool
    stopped: str
    state: str
    refused: tuple[tuple[str, int], ...] = ()
    """How many messages were refused or slowed, by reason."""
    body: bytes = b""
    """The identifier that commands and held buttons must repeat."""
    held_by: bytes = b""
    """Who holds the button that lets it drive; empty: nobody."""
    hold_to_run: bool = False
    """Whether nothing else arms it."""

    @property
    def news(self) -> tuple[object, ...]:
        """What is said at once when it changes; the rest ten times a second."""
        return self.lease.holder, self.lease.epoch, self.armed, self.stopped, self.held_by


def encode_lease(account: Account) -> bytes:
    """`reflexarc.Lease`."""
    lease = account.lease
    message = pb.Lease(
        holder=lease.holder,
        epoch=lease.epoch,
        armed=account.armed,
        stopped=account.stopped,
        state=account.state,
        refused=dict(account.refused),
        body=account.body,
        held_by=account.held_by,
        hold_to_run=account.hold_to_run,
    )
    return message.SerializeToString()
