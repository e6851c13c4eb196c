"""What `reflexarc run` records: the whole run, what a black box keeps, both, or nothing."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.wiring.keeping_logs.black_box_flags import BlackBoxFlags
from reflexarc.wiring.keeping_logs.outcome import Recording, recording_of
from reflexarc.wiring.keeping_logs.recording_flags import RecordingFlags, recording_place
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.sink import NoSink, Sink
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.wire import Message

if TYPE_CHECKING:  # a run that records nothing shall not load what records
    from reflexarc_logs.recording.black_box import BoxSpan
    from reflexarc_logs.recording.keeping import Keeping
    from reflexarc_logs.recording.recorder import Recorder

    MakeRecorder = Callable[[Path, Keeping, BoxSpan | None], Recorder]


@dataclass(frozen=True)
class RunSinks:
    """Hands every record to both; a `Sink`."""

    whole: Sink = field(default_factory=NoSink)
    box: Sink = field(default_factory=NoSink)

    @property
    def takes_any(self) -> bool:
        """Whether anything is recorded at all."""
        return bool(self._recorders())

    @property
    def state(self) -> str:
        """See `Sink.state`; what a box says stands behind it."""
        if isinstance(self.box, NoSink):
            return self.whole.state
        return f"{self.whole.state}; black box {self.box.state}"

    @property
    def recordings(self) -> dict[str, Recording]:
        """What became of them; they have been closed."""
        found = {"recording": recording_of(self.whole)}
        if not isinstance(self.box, NoSink):
            found["black box"] = recording_of(self.box)
        return found

    def put(self, message: Message) -> None:
        """See `Sink.put`."""
        self.whole.put(message)
        self.box.put(message)

    def put_tick(self, record: TickRecord) -> None:
        """See `Sink.put_tick`."""
        self.whole.put_tick(record)
        self.box.put_tick(record)

    def keep_policies(self, others: Mapping[str, bytes]) -> None:
        """Let what is begun from now on hold these policies as well, by their hashes."""
        for recorder in self._recorders():
            recorder.keep_policies(others)

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`."""
        self.whole.put_keyframe(keyframe)
        self.box.put_keyframe(keyframe)

    def _recorders(self) -> list["Recorder"]:
        """Those of the two that record."""
        sinks = [sink for sink in (self.whole, self.box) if not isinstance(sink, NoSink)]
        if not sinks:
            return []
        from reflexarc_logs.recording.recorder import Recorder

        return [sink for sink in sinks if isinstance(sink, Recorder)]


@contextmanager
def run_sinks(
    record: Path | None, flags: RecordingFlags, box: BlackBoxFlags, make: "MakeRecorder"
) -> Iterator[RunSinks]:
    """Record as the flags say, until it is left.

    Args:
        record: the log of the whole run, or a folder for it; None: none.
        flags: how it is kept.
        box: of the black box.
        make: makes a recorder.

    Raises:
        LogError: a log exists, or cannot be written.
        UsageError: a folder cannot be made.
    """
    keeping, span = flags.keeping("reflexarc run"), box.span
    with ExitStack() as stack:
        whole: Sink = NoSink()
        boxed: Sink = NoSink()
        if record is not None:
            whole = stack.enter_context(make(recording_place(record, keeping), keeping, None))
        if span is not None:
            of_box = box.keeping(keeping)
            boxed = stack.enter_context(make(box.place(of_box), of_box, span))
        yield RunSinks(whole, boxed)
