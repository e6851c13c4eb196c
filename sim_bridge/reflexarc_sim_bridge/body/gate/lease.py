"""The lease of a body: whom it obeys, since when, and who may be next.

The first who sends a valid command gets it, keeps it while it goes on sending, and loses it by a
release or by silence on the body's clock. After a release the former holder has to wait for as long
as a silence, so that another one comes first; a hand-over would be none otherwise, as it goes on
sending. In lockstep nothing expires, and nobody has to wait.
"""

from dataclasses import dataclass

NOBODY = b""


@dataclass(frozen=True, slots=True)
class Lease:
    """Who holds a body, if anybody does."""

    holder: bytes = NOBODY
    """Identifier of the sender; `NOBODY`: it is free."""
    epoch: int = 0
    """Grows with every grant."""
    heard_ns: int = 0
    """When the holder was heard last; of a free one, when it became free."""
    former: bytes = NOBODY
    """Who released it, and has to wait."""

    @property
    def is_free(self) -> bool:
        """Whether nobody holds it."""
        return self.holder == NOBODY

    def at(self, now_ns: int, silence_ns: int | None) -> "Lease":
        """The lease now: free after too long a silence; `silence_ns` None: nothing expires."""
        silent = silence_ns is not None and now_ns - self.heard_ns > silence_ns
        if not silent or (self.is_free and not self.former):
            return self
        return Lease(NOBODY, self.epoch, now_ns)

    def claimed(self, sender: bytes, now_ns: int, silence_ns: int | None) -> "Lease | None":
        """The lease after a valid command; None: its sender does not get it."""
        lease = self.at(now_ns, silence_ns)
        if lease.holder == sender:
            return Lease(sender, lease.epoch, now_ns)
        if lease.is_free and (lease.former != sender or silence_ns is None):
            return Lease(sender, lease.epoch + 1, now_ns)
        return None

    def released(self, now_ns: int, silence_ns: int | None) -> "Lease":
        """The lease after its release, whoever asked for it."""
        lease = self.at(now_ns, silence_ns)
        return lease if lease.is_free else Lease(NOBODY, lease.epoch, now_ns, lease.holder)
