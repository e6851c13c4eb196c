"""What became of a recording, for whoever started it."""

from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.loop.sink import NoSink, Sink

SHOWN_PARTS = 5


@dataclass(frozen=True)
class Recording:
    """What became of a recording."""

    state: str
    parts: tuple[Path, ...] = ()
    """The files that hold it; one whose name ends in `.partial` is not finished."""
    failed: bool = False
    """Whether a disk did not take what it should have."""

    @property
    def in_words(self) -> str:
        """Where it is and what is amiss, for a person."""
        names = self._names
        if not self.state.startswith("off"):
            return f"{self.state} ({names})" if names else self.state
        return f"{names}{self.state.removeprefix('off')}" if names else self.state

    @property
    def _names(self) -> str:
        if len(self.parts) <= SHOWN_PARTS:
            return ", ".join(map(str, self.parts))
        return f"{self.parts[0]} … {self.parts[-1]} ({len(self.parts)} parts)"


def recording_of(sink: Sink) -> Recording:
    """What became of what a sink recorded; it has been closed."""
    if isinstance(sink, NoSink):
        return Recording(sink.state)
    from reflexarc_logs.recording.recorder import Recorder  # has been loaded if it is one

    if isinstance(sink, Recorder):
        return Recording(sink.state, sink.parts, sink.failed)
    return Recording(sink.state)
