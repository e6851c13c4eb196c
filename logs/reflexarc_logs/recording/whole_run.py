"""Where a recording's entries go: all of them into one part after another.

A loop's part begins with a keyframe, so that it replays by itself; a listener on the bus has none.
"""

from typing import Protocol

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.part import Head, Part
from reflexarc_logs.recording.part_keeper import PartKeeper
from reflexarc_logs.recording.served_files import ServedFiles
from reflexarc_runtime.messages_pb2 import Keyframe

_EARLY_NS = 100_000_000
"""A keyframe bears the time of the tick before it: a part may be a tick shorter than asked for."""


class Destination(Protocol):
    """Takes the entries of a recording, in the recorder's thread."""

    @property
    def words(self) -> str:
        """What the status should say of it; may be empty."""
        ...

    def put(self, entry: LogEntry) -> None:
        """Take one entry."""
        ...

    def keep(self) -> None:
        """Called every `FLUSH_PERIOD_S`: bring all to the disk."""
        ...

    def finish(self) -> None:
        """No more will come; returns when the disk has all."""
        ...

    def fail(self, error: Exception) -> None:
        """One of the others raised this."""
        ...


class WholeRun:
    """Writes everything.

    Args:
        keeper: of the parts.
        keeping: when a part is full.
        head: of the parts.
        of_loop: whether keyframes come, and parts begin with them.
    """

    words = ""

    def __init__(self, keeper: PartKeeper, keeping: Keeping, head: Head, *, of_loop: bool) -> None:
        self._keeper, self._keeping, self._head = keeper, keeping, head
        self._passed = ServedFiles()
        self._of_loop = of_loop
        self._ended = ""

    def put(self, entry: LogEntry) -> None:
        """See `Destination.put`."""
        may_begin = is_keyframe(entry) or not self._of_loop
        if self._of_loop:
            self._passed.pass_by(entry)
        part = self._keeper.part
        if part is not None and may_begin:
            self._ended = self._limit(part, entry)
            if self._ended:
                self._keeper.finish()
        if self._keeper.part is not None or (may_begin and self._begin()):
            self._keeper.write(entry)
        else:
            self._keeper.lose()

    def keep(self) -> None:
        """See `Destination.keep`."""
        self._keeper.keep()

    def finish(self) -> None:
        """See `Destination.finish`."""
        self._keeper.end()

    def fail(self, error: Exception) -> None:
        """See `Destination.fail`."""
        self._keeper.fail(error)

    def _begin(self) -> bool:
        ended, self._ended = self._ended, ""
        self._head.earlier = self._passed.files
        if ended:
            return self._keeper.begin_next({"after": ended})
        return self._keeper.begin_again()

    def _limit(self, part: Part, entry: LogEntry) -> str:
        """Which limit the part has reached, if it has."""
        since_ns = entry.received_ns if part.begun_ns is None else part.begun_ns
        length_ns = entry.received_ns - since_ns + (_EARLY_NS if self._of_loop else 0)
        return self._keeping.exceeded(part.size_bytes, length_ns * 1e-9)


def is_keyframe(entry: LogEntry) -> bool:
    """Whether a loop said what it knew; whoever sends such a message on the bus is refused."""
    return entry.kind is Keyframe
