"""The recorder's thread: takes what waits, sorts it, hands it to its destination, flushes it
and looks whether the disk has it all.

What it notices itself (records dropped, a wall clock that was set) it writes into the log where it
noticed it, on `<robot>/log`.
"""

import time
from collections.abc import Callable
from functools import partial

from foxglove_schemas_protobuf.Log_pb2 import Log

from reflexarc_logs.container.rejected import Intake, LogEntry
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.recording.progress import Progress
from reflexarc_logs.recording.recording_account import RecordingAccount
from reflexarc_logs.recording.wall_clock import WallClock
from reflexarc_logs.recording.whole_run import Destination
from reflexarc_runtime.messages.topics import LOG

FLUSH_PERIOD_S = 0.8
"""What a kill costs: less than a second, with a fifth of one for a machine that is busy. Each flush
ends a chunk, and longer chunks are smaller."""
NEVER_S = 1e6
"""Longer than anything is decided anew."""
NAME = "recorder"
"""Of who speaks, in the log's messages."""


class Scribe:
    """Runs until the backlog ends.

    Args:
        run: whose run it is.
        account: where entries come from, and what is left out.
        progress: told what the thread does.
        destination: takes the entries.
    """

    def __init__(
        self, run: RunInfo, account: RecordingAccount, progress: Progress, destination: Destination
    ) -> None:
        self._account, self._progress = account, progress
        self._destination = destination
        self._intake = Intake(run.robot)
        self._log_key = LOG.key(run.robot)
        self._flush_period_s = NEVER_S if run.recorded_by == "decide" else FLUSH_PERIOD_S
        """A log that is decided anew is whole or not there, and the same bytes each time."""
        self._wall_clock = None if run.clock == "lockstep" else WallClock()
        self._last_ns: int | None = None
        self._notes = self._dropped = 0

    def run(self) -> None:
        """Write to the end."""
        due_s = time.monotonic() + self._flush_period_s
        while not self._account.backlog.ended:
            self._trying(partial(self._take, due_s - time.monotonic()))
            if time.monotonic() >= due_s:
                self._trying(self._look)
                due_s = time.monotonic() + self._flush_period_s
        self._trying(self._destination.finish)

    def _trying(self, act: Callable[[], None]) -> None:
        """Do it; whatever happens to a recording, the robot goes on."""
        try:
            act()
        except Exception as error:
            self._destination.fail(error)

    def _take(self, timeout_s: float) -> None:
        account = self._account
        if not account.backlog.waiting:
            self._progress.rest()
        entry = account.backlog.take(timeout_s)
        self._progress.work()
        if entry is None:
            return
        granted = account.budgets.granted(self._intake.sort(entry), time.monotonic())
        if granted is not None:
            self._last_ns = granted.received_ns
            self._destination.put(granted)

    def _look(self) -> None:
        self._destination.keep()
        dropped = self._account.backlog.dropped
        if dropped > self._dropped:
            self._note(f"{dropped - self._dropped} records dropped: the disk is too slow")
            self._dropped = dropped
        step = "" if self._wall_clock is None else self._wall_clock.look()
        if step:
            self._note(step)

    def _note(self, words: str) -> None:
        """Write a remark behind the newest entry, at its time: log time never goes back."""
        if self._last_ns is None:
            return
        said = Log(level=Log.WARNING, message=words, name=NAME)
        said.timestamp.FromNanoseconds(time.time_ns())
        payload = said.SerializeToString()
        entry = LogEntry(self._log_key, Log, payload, self._notes, None, self._last_ns)
        self._notes += 1
        self._destination.put(entry)
