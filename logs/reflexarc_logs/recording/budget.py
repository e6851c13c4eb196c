"""What others than the robot itself can make a recording write: so many bytes a second, no more.

Anyone on the bus can send on a robot's keys. Within a budget all of it is recorded; beyond it, in
this order:

1. of what cannot be decoded, only what made the loop refuse it: encoding, attachment, size, reason.
   That decides alike when it is replayed;
2. nothing, and it is counted. Of what reached the loop that breaks a replay at level `node`, and
   the log says so; what is only overheard decides nothing.

What the loop itself hands over is never left out, nor what the body sends that it is bound to, and
the range sensor of its guard: keyframes say who they are. Stops and resets have a budget of their
own: noise cannot push them out.
"""

from dataclasses import dataclass

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_runtime.messages.topics import (
    COMMAND,
    CONTROLS,
    KEYFRAME,
    REJECTED,
    SENSORS,
    SWAP,
    TICK,
    topic_of,
)
from reflexarc_runtime.messages_pb2 import Keyframe, Rejected

BURST_BYTES = 32 << 20
"""Of each budget: so much at once is recorded whole."""
NOISE_BYTES_PER_S = 128_000
"""Payloads that cannot be decoded: for whoever looks for their sender, not for replay."""
BRIEF_BYTES_PER_S = 2_000_000
"""What remains of them. An inbox passes at most 1024 messages a tick on."""
CONTROLS_BYTES_PER_S = 1_000_000
OTHERS_BYTES_PER_S = 4_000_000
"""All the rest; for a listener that is the whole robot. A lidar of 1080 beams at 40 Hz is 0.7 MB/s,
a simulated robot's own streams beside its sensor are 20 kB/s."""
ENTRY_BYTES = 64
"""What a message costs without its payload."""
ATTACHMENT_BYTES = 67
"""Of an attachment, enough to be refused for the same reason: one byte more than is quoted."""

_LOOPS_OWN = (TICK, COMMAND, KEYFRAME, SWAP)
_DECIDE = (*CONTROLS, *SENSORS.values())


@dataclass
class ByteBudget:
    """Bytes that may be written: a bucket that fills at a rate, up to a burst."""

    bytes_per_s: float
    burst_bytes: float = BURST_BYTES
    spent_bytes: float = 0.0
    last_s: float | None = None

    def affords(self, size: int, now_s: float) -> bool:
        """Spend so many bytes, if they are there."""
        if self.last_s is not None:
            self.spent_bytes -= (now_s - self.last_s) * self.bytes_per_s
        self.spent_bytes, self.last_s = max(0.0, self.spent_bytes), now_s
        if self.spent_bytes + size > self.burst_bytes:
            return False
        self.spent_bytes += size
        return True


class Budgets:
    """Decides what of each entry is written.

    Args:
        of_loop: whether a loop hands over its own ticks and commands; else they are heard on the
            bus, where anyone can send them.
    """

    def __init__(self, *, of_loop: bool) -> None:
        self._loops_own = _LOOPS_OWN if of_loop else ()
        self._noise = ByteBudget(NOISE_BYTES_PER_S)
        self._brief = ByteBudget(BRIEF_BYTES_PER_S)
        self._controls = ByteBudget(CONTROLS_BYTES_PER_S)
        self._others = ByteBudget(OTHERS_BYTES_PER_S)
        self._bound: frozenset[bytes] = frozenset()
        self.missing = 0
        """Messages left out that reached a loop: they may have decided."""
        self.beside = 0
        """Messages left out that decided nothing."""

    def granted(self, entry: LogEntry, now_s: float) -> LogEntry | None:
        """What is written of an entry; None: nothing, and it is counted.

        Args:
            entry: as it would be written.
            now_s: of a clock that never goes back.
        """
        topic = topic_of(entry.key)
        if topic is REJECTED:
            return self._granted_of_noise(entry, now_s)
        if topic in self._loops_own:
            if topic is KEYFRAME:
                self._bound = _bound(Keyframe.FromString(entry.payload))
            return entry
        if entry.sender in self._bound:
            return entry
        budget = self._controls if topic in CONTROLS else self._others
        return self._whole(entry, budget, entry.key, now_s)

    def _granted_of_noise(self, entry: LogEntry, now_s: float) -> LogEntry | None:
        if self._noise.affords(ENTRY_BYTES + len(entry.payload), now_s):
            return entry
        rejected = Rejected.FromString(entry.payload)
        if topic_of(rejected.key) in CONTROLS or rejected.reason.startswith("sender"):
            # A stop of which nothing can be read stops all the same, in its own words; a good
            # message of one sender too many may be the next body's. Both are kept whole, or not.
            budget = self._controls if topic_of(rejected.key) in CONTROLS else self._others
            return self._whole(entry, budget, rejected.key, now_s)
        return self._whole(shortened(entry, rejected), self._brief, rejected.key, now_s)

    def _whole(
        self, entry: LogEntry, budget: ByteBudget, key: str, now_s: float
    ) -> LogEntry | None:
        """The entry, if a budget affords it; else it is counted by its key on the bus."""
        if budget.affords(ENTRY_BYTES + len(entry.payload), now_s):
            return entry
        if topic_of(key) in _DECIDE:
            self.missing += 1
        else:
            self.beside += 1
        return None


def shortened(entry: LogEntry, rejected: Rejected) -> LogEntry:
    """A message that cannot be decoded, without its payload: it is refused in the same words."""
    brief = Rejected(
        key=rejected.key,
        encoding=rejected.encoding,
        attachment=rejected.attachment[:ATTACHMENT_BYTES],
        reason=rejected.reason,
        payload_bytes=rejected.payload_bytes,
    )
    return LogEntry(
        entry.key,
        entry.kind,
        brief.SerializeToString(),
        entry.sequence,
        entry.sent_ns,
        entry.received_ns,
    )


def _bound(keyframe: Keyframe) -> frozenset[bytes]:
    """Whose messages decide, as a loop knew it once a second."""
    fields = ("source", "ranges_source")
    return frozenset(getattr(keyframe, f).sender for f in fields if keyframe.HasField(f))
