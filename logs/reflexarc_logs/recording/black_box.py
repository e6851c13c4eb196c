"""A black box: the last seconds of a run, written out when something happens, and some after it.

Each time is a log of its own, which begins with a keyframe. While one is written, whatever else
happens makes it longer; one that goes on for too long is continued in the next part.
"""

from dataclasses import dataclass

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_logs.recording.part import Head
from reflexarc_logs.recording.part_keeper import PartKeeper
from reflexarc_logs.recording.recording_account import RecordingAccount
from reflexarc_logs.recording.ring import Ring
from reflexarc_logs.recording.served_files import ServedFiles
from reflexarc_logs.recording.triggers import Triggers
from reflexarc_logs.recording.whole_run import is_keyframe
from reflexarc_runtime.messages_pb2 import Command, Tick

DEFAULT_AFTER_S = 5.0
MOST_PART_S = 600.0
"""Where something happens again and again, a part ends after so long."""
TRIGGER = "trigger"
"""In the metadata `reflexarc.part`: what happened."""


@dataclass(frozen=True)
class BoxSpan:
    """How much a black box writes."""

    before_s: float
    after_s: float = DEFAULT_AFTER_S


class BlackBox:
    """Writes what lies around whatever happens; a `Destination`.

    Args:
        keeper: of the parts; none is open.
        account: what is amiss.
        span: how much of it.
        head: of the parts.
    """

    def __init__(
        self, keeper: PartKeeper, account: RecordingAccount, span: BoxSpan, head: Head
    ) -> None:
        self._keeper, self._account, self._head = keeper, account, head
        self._passed = ServedFiles()
        self._ring = Ring(span.before_s)
        self._after_ns = round(span.after_s * 1e9)
        self._triggers = Triggers()
        self._why = ""
        """What happened last, as long as it is to be written."""
        self._now_ns = self._until_ns = 0
        self._written = 0

    @property
    def words(self) -> str:
        """See `Destination.words`."""
        part = self._keeper.part
        if part is not None:
            return f"writes {part.path.name}"
        return f"{self._written} written" if self._written else ""

    def put(self, entry: LogEntry) -> None:
        """See `Destination.put`."""
        if entry.kind in (Tick, Command):  # the loop's own time: others may tell another one
            self._now_ns = entry.received_ns
        self._ring.add(entry, self._account.left_out())
        self._passed.pass_by(entry)
        why = self._triggers.look(entry)
        if why:
            self._why, self._until_ns = why, self._now_ns + self._after_ns
        elif self._why and self._now_ns > self._until_ns and entry.kind is not Command:
            self._end()
        if self._why:
            self._write(entry, tries=bool(why) or is_keyframe(entry))

    def keep(self) -> None:
        """See `Destination.keep`."""
        self._keeper.keep()

    def finish(self) -> None:
        """See `Destination.finish`."""
        self._written += self._keeper.part is not None
        self._keeper.end()

    def fail(self, error: Exception) -> None:
        """See `Destination.fail`."""
        self._keeper.fail(error)

    def _write(self, entry: LogEntry, *, tries: bool) -> None:
        part = self._keeper.part
        if part is not None and is_keyframe(entry) and part.begun_ns is not None:
            if entry.received_ns - part.begun_ns >= MOST_PART_S * 1e9:
                self._keeper.finish()
                self._head.earlier = self._passed.files
                self._keeper.begin_next({"after": f"{MOST_PART_S:g} s", TRIGGER: self._why})
            part = self._keeper.part
        if part is not None:
            part.write(entry)
        elif tries and self._begin():
            for earlier in self._ring:
                self._keeper.write(earlier)
            self._keeper.keep()  # what was in memory is of seconds ago: no kill may take it now

    def _begin(self) -> bool:
        about = {TRIGGER: self._why}
        before = self._ring.left_out
        if before is None:
            return False  # no keyframe yet
        self._head.earlier = self._ring.policies
        begin = self._keeper.begin_again if self._account.failure else self._keeper.begin_next
        return begin(about, before)

    def _end(self) -> None:
        self._why = ""
        if self._keeper.part is not None:
            self._keeper.finish()
            self._written += 1
