"""The recorder: writes one run to one MCAP file, from a thread of its own.

The loop only puts records into a queue. The owner thread checks that each one can be decoded,
writes it, and flushes every half second: killed at any moment, a recording loses less than one
second. With each flush it looks whether the file is still there and the disk has room. A disk that
fails stops the recording, loudly, and not the robot; once it can take a log again, the recording
goes on in a new part, from the next keyframe on.

`log_time` is the arrival on the runtime's monotonic clock plus the wall clock's offset at the
start: a step of the wall clock does not show in it, and replay gets the arrival back exactly.
"""

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from reflexarc_logs.container.rejected import Intake
from reflexarc_logs.container.run_info import WALL_CLOCK, RunInfo
from reflexarc_logs.recording.backlog import Backlog, Entry
from reflexarc_logs.recording.budget import Budgets
from reflexarc_logs.recording.part import Head, Part
from reflexarc_logs.recording.place import DEFAULT_RESERVE_BYTES, LostPlaceError, NoRoomError
from reflexarc_logs.recording.progress import Progress
from reflexarc_logs.recording.recording_notices import RecordingNotices
from reflexarc_logs.recording.series import Series
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.rules import CURRENT_RULES

FLUSH_PERIOD_S = 0.5
PATIENCE_S = 20.0
"""How long the end of a recording waits for a disk that does nothing."""
_WAIT_S = 1.0


class Recorder:
    """A `Sink` that writes a log. A context manager; leaving it finishes the file.

    Args:
        path: the log to be; it must not exist. Until it is finished it is `path` + `.partial`.
        run: what the log says about the run; `policy_hash`, `wall_offset_ns` and `rules` are
            filled in.
        policy: the policy file, attached as `policy.onnx`; empty where none is known.
        config: the resolved configuration, attached as `config.json`.
        wall_offset_ns: wall clock minus monotonic clock at the start; 0 in lockstep.
        reserve_bytes: what shall stay free on the disk, at most a tenth of it.

    Raises:
        LogError: the path exists, cannot be written, or there is no room.
    """

    def __init__(
        self,
        path: Path | str,
        run: RunInfo,
        policy: bytes,
        config: Mapping[str, Any],
        *,
        wall_offset_ns: int,
        reserve_bytes: int = DEFAULT_RESERVE_BYTES,
    ) -> None:
        run = replace(
            run,
            policy_hash=policy_hash(policy) if policy else "",
            # A robot without a clock may boot before 1970 + its uptime; no time is negative.
            wall_offset_ns=max(0, wall_offset_ns),
            publish_clock=WALL_CLOCK,
            rules=CURRENT_RULES.version,
        )
        self._begins_with_keyframes = run.recorded_by == "run"
        self._intake = Intake(run.robot)
        self._budgets = Budgets(of_loop=self._begins_with_keyframes)
        self._backlog = Backlog()
        self._progress, self._notices = Progress(), RecordingNotices()
        self._failure = ""
        """Why nothing is recorded just now."""
        self._failures: list[str] = []
        self._trouble = ""
        self._closed = False
        self._lost = 0
        self._series = Series(Path(path), Head(run, policy, config), reserve_bytes)
        self._before = self._left_out()
        self._held: Entry | None = None
        self._owner = threading.Thread(target=self._own, name="recorder", daemon=True)
        self._owner.start()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def path(self) -> Path:
        """Where the finished log will be; its first part, if there are several."""
        return self._series.parts[0].path

    @property
    def parts(self) -> tuple[Path, ...]:
        """All that was written, under the names that it has now: an unfinished part is `.partial`;
        what was deleted is not among them.
        """
        return tuple(path for path in self._series.paths if path.exists())

    @property
    def failed(self) -> bool:
        """Whether anything is missing in the recording that a disk should have taken."""
        return bool(self._failures or self._backlog.dropped)

    @property
    def state(self) -> str:
        """See `Sink.state`: `on`, `off` after close, and what is amiss; or why it stopped."""
        if self._failure:
            return f"stopped: {self._failure}"
        return ", ".join(filter(None, ["off" if self._closed else "on", *self._amiss()]))

    @property
    def dropped(self) -> int:
        """Records lost because the disk could not follow."""
        return self._backlog.dropped

    def put(self, message: Message) -> None:
        """See `Sink.put`; from any thread."""
        if not self._closed:
            self._backlog.put(message)

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`; encoded in the recorder's own thread."""
        if not self._closed:
            self._backlog.put(keyframe)

    def close(self) -> None:
        """Write what is queued and finish the file; a second call does nothing.

        A disk that does nothing for `PATIENCE_S` is not waited for any longer.
        """
        if not self._closed:
            self._closed = True
            self._backlog.end()
        done = -1
        while self._owner.is_alive() and self._progress.steps != done:
            done = self._progress.steps
            self._owner.join(PATIENCE_S)
        if self._owner.is_alive() and not self._failure:
            self._note_failure(f"the disk did not answer for {PATIENCE_S:g} s")

    def _amiss(self) -> list[str]:
        strangers = self._budgets.missing + self._budgets.beside
        return [
            *(f"again in {self._series.current.path.name} after: {r}" for r in self._failures[-1:]),
            self._trouble,
            "" if self._closed else self._progress.behind_in_words(self._backlog.waiting),
            f"{self._backlog.dropped} records dropped" if self._backlog.dropped else "",
            f"{strangers} messages of others left out" if strangers else "",
        ]

    def _own(self) -> None:
        """Run the thread that owns the files."""
        part: Part | None = self._series.current
        while part is not None:
            self._fill(part)
            part = self._next_part() if self._failure else None

    def _fill(self, part: Part) -> None:
        """Write a part to its end; whatever happens to a recording, the robot goes on."""
        try:
            self._write_until_closed(part)
            part.finish(self._missing())
        except NoRoomError as error:
            self._fail(part, str(error), lambda: part.finish(self._missing()))
        except LostPlaceError as error:
            self._fail(part, str(error), part.end)
        except Exception as error:
            reason = (error.strerror if isinstance(error, OSError) else None) or repr(error)
            self._fail(part, reason, part.abandon)

    def _write_until_closed(self, part: Part) -> None:
        flush_due_s = time.monotonic() + FLUSH_PERIOD_S
        while self._held is not None or not self._backlog.ended:
            entry = self._take(flush_due_s - time.monotonic())
            if entry is not None:
                self._write(part, entry)
            if time.monotonic() >= flush_due_s:
                self._trouble = part.keep(self._missing())
                self._notices.look(part.path, self._trouble, self._backlog.dropped)
                flush_due_s = time.monotonic() + FLUSH_PERIOD_S

    def _take(self, timeout_s: float) -> Entry | None:
        if not self._backlog.waiting:
            self._progress.rest()
        held, self._held = self._held, None
        entry = held or self._backlog.take(timeout_s)
        self._progress.work()
        return entry

    def _write(self, part: Part, entry: Entry) -> None:
        granted = self._budgets.granted(self._intake.sort(entry), time.monotonic())
        if granted is not None:
            part.write(granted)

    def _next_part(self) -> Part | None:
        """Wait until the disk can take a new part, and lose what comes meanwhile.

        A part begins with a keyframe, so that it replays; a listener on the bus has none.
        """
        while not self._backlog.ended:
            entry = self._take(_WAIT_S)
            if isinstance(entry, Keyframe) or (entry and not self._begins_with_keyframes):
                part = self._series.begin(self._failure, self._lost)
                if part is not None:
                    self._held = entry
                    self._go_on(part)
                    return part
            self._lost += entry is not None
        return None

    def _go_on(self, part: Part) -> None:
        self._notices.goes_on(part.path, self._lost)
        self._failure, self._trouble, self._lost = "", "", 0
        self._before = self._left_out()

    def _left_out(self) -> dict[str, int]:
        missing = self._backlog.dropped + self._budgets.missing
        return {"dropped": missing, "left_out": self._budgets.beside}

    def _missing(self) -> dict[str, int]:
        """What is missing in the middle of this part."""
        return {kind: count - self._before[kind] for kind, count in self._left_out().items()}

    def _fail(self, part: Part, reason: str, leave: Callable[[], None]) -> None:
        self._note_failure(reason)  # at once: leaving a file may take long
        self._series.failed()
        try:
            leave()
        except Exception:  # it failed already; this is for what may still be saved
            part.abandon()
        self._notices.stopped(part.path, reason, part.place_now)

    def _note_failure(self, reason: str) -> None:
        self._failures.append(reason)
        self._failure = reason
