"""The last seconds of a run, in memory: from one keyframe to the next, the oldest ones dropped."""

from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_logs.recording.served_files import ServedFiles
from reflexarc_logs.recording.whole_run import is_keyframe

MOST_BYTES = 256 << 20
ENTRY_BYTES = 400
"""What an entry costs in memory without its payload."""


@dataclass
class _Stretch:
    """A keyframe, and what came behind it."""

    since_ns: int
    left_out: Mapping[str, int]
    """What was missing before it."""
    entries: list[LogEntry] = field(default_factory=list)
    size_bytes: int = 0


class Ring:
    """Holds the last seconds; nothing before the first keyframe, as it would not replay.

    Args:
        span_s: how much it holds at least, once so much has come.
        most_bytes: but no more than this; then it holds less.
    """

    def __init__(self, span_s: float, most_bytes: int = MOST_BYTES) -> None:
        self._span_ns = round(span_s * 1e9)
        self._most_bytes = most_bytes
        self._stretches: deque[_Stretch] = deque()
        self._size_bytes = 0
        self._passed = ServedFiles()

    @property
    def policies(self) -> Mapping[str, bytes]:
        """By hash, who serves where it begins, and whose swaps it no longer holds."""
        return self._passed.files

    @property
    def left_out(self) -> Mapping[str, int] | None:
        """What was missing before it begins; None if it is empty."""
        return self._stretches[0].left_out if self._stretches else None

    @property
    def size_bytes(self) -> int:
        """What it holds."""
        return self._size_bytes

    def add(self, entry: LogEntry, left_out: Mapping[str, int]) -> None:
        """Add an entry.

        Args:
            entry: the newest one.
            left_out: what is missing so far.
        """
        if is_keyframe(entry):
            self._stretches.append(_Stretch(entry.received_ns, dict(left_out)))
            self._forget(entry.received_ns - self._span_ns)
        if len(self._stretches) < 2 and (is_keyframe(entry) or not self._stretches):
            self._passed.pass_by(entry)  # it begins here, or later
        if self._stretches:
            size = ENTRY_BYTES + len(entry.payload)
            self._stretches[-1].entries.append(entry)
            self._stretches[-1].size_bytes += size
            self._size_bytes += size
        while self._size_bytes > self._most_bytes:
            self._drop()

    def __iter__(self) -> Iterator[LogEntry]:
        """All that it holds, the oldest first; that is a keyframe."""
        for stretch in self._stretches:
            yield from stretch.entries

    def _forget(self, before_ns: int) -> None:
        while len(self._stretches) > 1 and self._stretches[1].since_ns <= before_ns:
            self._drop()

    def _drop(self) -> None:
        dropped = self._stretches.popleft()
        self._size_bytes -= dropped.size_bytes
        for entry in dropped.entries:
            self._passed.pass_by(entry)
        if self._stretches:
            self._passed.pass_by(self._stretches[0].entries[0])
