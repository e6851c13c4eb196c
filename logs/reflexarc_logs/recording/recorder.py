"""The recorder: writes one run to MCAP files, from a thread of its own.

The loop only puts records into a queue. The owner thread checks that each one can be decoded,
writes it, and flushes every half second: killed at any moment, a recording loses less than one
second. With each flush it looks whether the file is still there and the disk has room. A disk that
fails stops the recording, loudly, and not the robot; once it can take a log again, the recording
goes on in a new part, from the next keyframe on. New parts begin as well where a part is full; and
a black box writes only where something happened.

`log_time` is the arrival on the runtime's monotonic clock plus the wall clock's offset at the
start: a step of the wall clock does not show in it, and replay gets the arrival back exactly.
"""

import threading
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from reflexarc_logs.container.run_info import WALL_CLOCK, RunInfo
from reflexarc_logs.recording.backlog import Backlog
from reflexarc_logs.recording.black_box import BlackBox, BoxSpan
from reflexarc_logs.recording.budget import Budgets
from reflexarc_logs.recording.keeping import DEFAULT_KEEPING, Keeping
from reflexarc_logs.recording.part import Head
from reflexarc_logs.recording.part_keeper import PartKeeper
from reflexarc_logs.recording.progress import Progress
from reflexarc_logs.recording.recording_account import RecordingAccount
from reflexarc_logs.recording.scribe import Scribe
from reflexarc_logs.recording.series import Series
from reflexarc_logs.recording.whole_run import Destination, WholeRun
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.rules import CURRENT_RULES

PATIENCE_S = 20.0
"""How long the end of a recording waits for a disk that does nothing."""


NO_OTHERS: Mapping[str, bytes] = {}


class Recorder:
    """A `Sink` that writes a log. A context manager; leaving it finishes the file.

    Args:
        path: the log to be; it must not exist. Until it is finished it is `path` + `.partial`. Or
            a folder, which takes many recordings: this one gets a name of its own in it.
        run: what the log says about the run; `policy_hash`, `wall_offset_ns` and `rules` are
            filled in.
        policy: the policy file, attached as `policy.onnx`; empty where none is known.
        config: the resolved configuration, attached as `config.json`.
        others: see `Head.others`.
        wall_offset_ns: wall clock minus monotonic clock at the start; 0 in lockstep.
        keeping: when a new part begins, how much is kept, what stays free.
        box: write only so much around whatever happens; None: everything.

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
        others: Mapping[str, bytes] = NO_OTHERS,
        wall_offset_ns: int,
        keeping: Keeping = DEFAULT_KEEPING,
        box: BoxSpan | None = None,
    ) -> None:
        run = replace(
            run,
            policy_hash=policy_hash(policy) if policy else "",
            # A robot without a clock may boot before 1970 + its uptime; no time is negative.
            wall_offset_ns=max(0, wall_offset_ns),
            publish_clock=WALL_CLOCK,
            rules=CURRENT_RULES.version,
        )
        of_loop = run.recorded_by == "run"
        self._backlog, self._budgets = Backlog(), Budgets(of_loop=of_loop)
        self._progress, self._account = Progress(), RecordingAccount(self._backlog, self._budgets)
        head = self._head = Head(run, policy, config, others)
        self._series = Series(Path(path), head, keeping, at_once=box is None)
        keeper = PartKeeper(self._series, self._account)
        self._destination: Destination = (
            WholeRun(keeper, keeping, head, of_loop=of_loop)
            if box is None
            else BlackBox(keeper, self._account, box, head)
        )
        self._closed = False
        scribe = Scribe(run, self._account, self._progress, self._destination)
        self._owner = threading.Thread(target=scribe.run, name="recorder", daemon=True)
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
        return self._series.path

    @property
    def parts(self) -> tuple[Path, ...]:
        """All that was written, under the names that it has now: an unfinished part is `.partial`;
        what was deleted is not among them.
        """
        return tuple(path for path in self._series.paths if path.exists())

    @property
    def failed(self) -> bool:
        """Whether anything is missing in the recording that a disk should have taken."""
        return bool(self._account.failures or self._backlog.dropped)

    @property
    def state(self) -> str:
        """See `Sink.state`: `on`, `off` after close, and what is amiss; or why it stopped."""
        if self._account.failure:
            return f"stopped: {self._account.failure}"
        first = "off" if self._closed else "on"
        return ", ".join(filter(None, [first, self._destination.words, *self._amiss()]))

    @property
    def dropped(self) -> int:
        """Records lost because the disk could not follow."""
        return self._backlog.dropped

    def put(self, message: Message) -> None:
        """See `Sink.put`; from any thread."""
        if not self._closed:
            self._backlog.put(message)

    def put_tick(self, record: TickRecord) -> None:
        """See `Sink.put_tick`; what the log holds of it is made in the recorder's own thread."""
        if not self._closed:
            self._backlog.put_tick(record)

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`; encoded in the recorder's own thread."""
        if not self._closed:
            self._backlog.put(keyframe)

    def keep_policies(self, others: Mapping[str, bytes]) -> None:
        """Let what is begun from now on hold these policies beside the first one; any thread."""
        self._head.others = others

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
        if self._owner.is_alive() and not self._account.failure:
            self._account.note_failure(f"the disk did not answer for {PATIENCE_S:g} s")

    def _amiss(self) -> list[str]:
        again = f"again in {self._account.again_in} after: "
        strangers = self._budgets.missing + self._budgets.beside
        return [
            *(again + reason for reason in self._account.failures[-1:]),
            self._account.trouble,
            "" if self._closed else self._behind(),
            f"{self._backlog.dropped} records dropped" if self._backlog.dropped else "",
            f"{strangers} messages of others left out" if strangers else "",
        ]

    def _behind(self) -> str:
        disk_since_s = self._series.syncer.waits_since_s
        return self._progress.behind_in_words(self._backlog.waiting, disk_since_s)
