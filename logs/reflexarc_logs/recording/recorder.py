"""The recorder: writes one run to one MCAP file, from a thread of its own.

The loop only puts records into a queue. The owner thread checks that each one can be decoded,
writes it, and flushes every half second: killed at any moment, a recording loses less than one
second. A full disk stops the recording, loudly, and not the robot.

`log_time` is the arrival on the runtime's monotonic clock plus the wall clock's offset at the
start: a step of the wall clock does not show in it, and replay gets the arrival back exactly.
"""

import json
import logging
import threading
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from reflexarc_logs.container.rejected import Intake, LogEntry
from reflexarc_logs.container.run_info import RUN, RunInfo
from reflexarc_logs.container.writing import CONFIG_ATTACHMENT, END, POLICY_ATTACHMENT, LogWriter
from reflexarc_logs.recording.backlog import Backlog
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.rules import CURRENT_RULES

FLUSH_PERIOD_S = 0.5

_LOG = logging.getLogger(__name__)


class Recorder:
    """A `Sink` that writes a log. A context manager; leaving it finishes the file.

    Args:
        path: the log to be; it must not exist. Until it is finished it is `path` + `.partial`.
        run: what the log says about the run; `policy_hash`, `wall_offset_ns` and `rules` are
            filled in.
        policy: the policy file, attached as `policy.onnx`; empty where none is known.
        config: the resolved configuration, attached as `config.json`.
        wall_offset_ns: wall clock minus monotonic clock at the start; 0 in lockstep.

    Raises:
        LogError: the path exists, or cannot be written.
    """

    def __init__(
        self,
        path: Path | str,
        run: RunInfo,
        policy: bytes,
        config: Mapping[str, Any],
        *,
        wall_offset_ns: int,
    ) -> None:
        # A robot without a clock may boot before 1970 + its uptime; a log has no negative times.
        self._offset_ns = max(0, wall_offset_ns)
        identity = policy_hash(policy) if policy else ""
        self._run = replace(
            run,
            policy_hash=identity,
            wall_offset_ns=self._offset_ns,
            rules=CURRENT_RULES.version,
        )
        self._intake = Intake(run.robot)
        self._backlog = Backlog()
        self._failure = ""
        self._closed = False
        self._file = LogWriter(Path(path))
        self._begin(policy, config)
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
        """Where the finished log will be."""
        return self._file.path

    @property
    def state(self) -> str:
        """See `Sink.state`: `on` (and how much was dropped), `off` after close, or a failure."""
        if self._failure:
            return f"stopped: {self._failure}"
        dropped = f", {self._backlog.dropped} records dropped" if self._backlog.dropped else ""
        return ("off" if self._closed else "on") + dropped

    @property
    def dropped(self) -> int:
        """Records lost because the disk could not follow."""
        return self._backlog.dropped

    def put(self, message: Message) -> None:
        """See `Sink.put`; from any thread."""
        if not self._failure and not self._closed:
            self._backlog.put(message)

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`; encoded in the recorder's own thread."""
        if not self._failure and not self._closed:
            self._backlog.put(keyframe)

    def close(self) -> None:
        """Write what is queued and finish the file; a second call does nothing."""
        if not self._closed:
            self._closed = True
            self._backlog.end()
        self._owner.join()

    def _begin(self, policy: bytes, config: Mapping[str, Any]) -> None:
        """Write what a log must hold even if it ends at once."""
        try:
            self._file.describe(RUN, self._run.to_metadata())
            if policy:
                self._file.attach(POLICY_ATTACHMENT, "application/onnx", policy)
            document = json.dumps(config, indent=2, sort_keys=True).encode()
            self._file.attach(CONFIG_ATTACHMENT, "application/json", document)
            self._file.flush()
        except OSError as error:
            self._file.discard()
            raise LogError(f"{self.path}: cannot be written: {error.strerror}") from None
        except BaseException:  # a configuration that is not JSON is the caller's mistake
            self._file.discard()
            raise

    def _own(self) -> None:
        """Run the thread that owns the file."""
        try:
            self._write_until_closed()
            if self._backlog.dropped:
                self._file.describe(END, {"dropped": str(self._backlog.dropped)})
            self._file.finish()
        except Exception as error:  # whatever happens to a recording, the robot goes on
            self._fail(error)

    def _write_until_closed(self) -> None:
        flush_due_s = time.monotonic() + FLUSH_PERIOD_S
        told = 0
        while not self._backlog.ended:
            entry = self._backlog.take(flush_due_s - time.monotonic())
            if entry is not None:
                self._write(self._intake.sort(entry))
            if time.monotonic() >= flush_due_s:
                self._file.flush()
                flush_due_s = time.monotonic() + FLUSH_PERIOD_S
                told = self._tell_of_drops(told)

    def _write(self, entry: LogEntry) -> None:
        channel = self._file.channel(f"/{entry.key}", entry.kind, entry.sender)
        log_ns = entry.received_ns + self._offset_ns
        self._file.add(
            channel,
            entry.payload,
            sequence=entry.sequence,
            publish_ns=log_ns if entry.sent_ns is None else entry.sent_ns,
            log_ns=log_ns,
        )

    def _tell_of_drops(self, told: int) -> int:
        dropped = self._backlog.dropped
        if dropped > told:
            _LOG.error("%s: the disk is too slow: %d records dropped", self.path, dropped)
        return dropped

    def _fail(self, error: Exception) -> None:
        reason = (error.strerror if isinstance(error, OSError) else None) or repr(error)
        self._failure = reason
        self._backlog.clear()
        self._file.abandon()
        _LOG.error(
            "%s: the recording stopped: %s; the robot goes on. What was written is in %s",
            self.path,
            reason,
            self._file.partial,
        )
