"""One part of a recording: a log of its own, which begins with all that a log must hold."""

import contextlib
import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from reflexarc_logs.container.packing.compression import (
    Compressor,
    FixedCompressor,
    ThriftyCompressor,
)
from reflexarc_logs.container.rejected import LogEntry
from reflexarc_logs.container.run_info import RUN, RunInfo
from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_logs.container.writing import (
    CONFIG_ATTACHMENT,
    END,
    POLICY_ATTACHMENT,
    LogWriter,
    attachment_of,
)
from reflexarc_logs.recording.keeping import DEFAULT_SYNC_S
from reflexarc_logs.recording.place import NoRoomError, Place
from reflexarc_logs.recording.syncer import DiskTask, Syncer
from reflexarc_runtime.errors import LogError

PART = "reflexarc.part"
"""Metadata of every part but the first: its number, the first one's name, why it was begun; of what
a black box wrote, of the first as well."""
PART_OF = "of"
MAX_PARTS = 1_000_000
"""A part every ten seconds for four months."""

_EARLY_S = 0.25
"""A sync is done with a flush, if it is due by then or soon after."""
_SYNC_SHARE = 4.0
"""A disk that takes long to sync is left alone for so many times as long."""


@dataclass
class Head:
    """What every part begins with.

    Args:
        run: what the log says about the run.
        policy: attached as `policy.onnx`; empty where none is known.
        config: attached as `config.json`.
        others: policies that may decide or watch beside it, by their hashes; attached by these. A
            part that begins later begins with those of then.
    """

    run: RunInfo
    policy: bytes
    config: Mapping[str, Any]
    others: Mapping[str, bytes] = field(default_factory=dict)
    earlier: Mapping[str, bytes] = field(default_factory=dict)
    """Those who serve, served or are to serve where the next part begins, as far as their swaps
    have passed: what waits to be written may be of long ago."""

    def write(self, file: LogWriter, part: Mapping[str, str]) -> None:
        """Write it."""
        file.describe(RUN, self.run.to_metadata())
        if part:
            file.describe(PART, part)
        if self.policy:
            file.attach(POLICY_ATTACHMENT, "application/onnx", self.policy)
        for identity, policy in {**self.earlier, **self.others}.items():
            file.attach(attachment_of(identity), "application/onnx", policy)
        document = json.dumps(self.config, indent=2, sort_keys=True).encode()
        file.attach(CONFIG_ATTACHMENT, "application/json", document)
        file.flush()


class Part:
    """A log that is being written.

    Args:
        path: its name when it is finished.
        head: what it begins with.
        place: where it is.
        part: what it says of itself, if it is not the first.
        sync_s: how often it is synced.
        syncer: waits for the disk; by default, one of its own.

    Raises:
        LogError: it exists, cannot be written, or there is no room.
    """

    def __init__(
        self,
        path: Path,
        head: Head,
        place: Place,
        part: Mapping[str, str] | None = None,
        sync_s: float = DEFAULT_SYNC_S,
        syncer: Syncer | None = None,
    ) -> None:
        self.path = path
        self.begun_ns: int | None = None
        """Time of its first entry, on the clock of the loop."""
        self._period_s = max(0.0, sync_s - _EARLY_S)
        self._place = place
        self._syncer = syncer or Syncer()
        self._sync: DiskTask | None = None
        self._offset_ns = head.run.wall_offset_ns
        self._publish_shift_ns = head.run.publish_shift_ns
        self._is_finished = False
        self._said: dict[str, str] = {}
        self._file = LogWriter(path, compressor=_compressor_of(head.run))
        self._sync_due_s = time.monotonic() + self._period_s
        try:
            head.write(self._file, part or {})
            place.check_room()
        except OSError as error:
            self._file.discard()
            raise LogError(f"{path}: cannot be written: {error.strerror}") from None
        except NoRoomError as error:
            self._file.discard()
            raise LogError(f"{path}: {error}; make room, or see --reserve-mb") from None
        except BaseException:  # a configuration that is not JSON is the caller's mistake
            self._file.discard()
            raise

    @property
    def partial(self) -> Path:
        """Its name until it is finished."""
        return self._file.file.partial

    @property
    def place_now(self) -> Path:
        """The name that it has now."""
        return self.path if self._is_finished else self.partial

    @property
    def size_bytes(self) -> int:
        """What is on the disk; the last flush may be most of a second ago."""
        return os.fstat(self._file.file.fileno()).st_size

    @property
    def sync_error(self) -> Exception | None:
        """Why the last sync failed: then the system refuses whatever comes next, in other words."""
        return self._sync.error if self._sync is not None and self._sync.is_done else None

    def write(self, entry: LogEntry) -> None:
        """Write one entry."""
        self._hear_of_sync()  # at once: a disk that failed is to be said within two seconds
        if self.begun_ns is None:
            self.begun_ns = entry.received_ns
        channel = self._file.channel(f"/{entry.key}", entry.kind, entry.sender)
        log_ns = entry.received_ns + self._offset_ns
        self._file.add(
            channel,
            entry.payload,
            sequence=entry.sequence,
            publish_ns=self._published_ns(entry, log_ns),
            log_ns=log_ns,
        )

    def _published_ns(self, entry: LogEntry, log_ns: int) -> int:
        """When it was sent, by the clock that this log says; of what has no stamp, the arrival."""
        return log_ns if entry.sent_ns is None else entry.sent_ns + self._publish_shift_ns

    def keep(self, missing: Mapping[str, int]) -> str:
        """Hand all to the system, have it synced from time to time, and look whether it is there.

        Args:
            missing: how much is missing in its middle, by kind.

        Returns:
            What will keep it from getting its name; empty if nothing will.

        Raises:
            OSError: the disk did not take it.
            LostPlaceError: the file is no longer where it should be.
            NoRoomError: less is free than the reserve.
        """
        self.say_missing(missing)
        self._file.flush()
        trouble = self._look()
        self._keep_synced()
        return trouble

    def say_missing(self, missing: Mapping[str, int]) -> None:
        """Write how much is missing, if that is more than was said: the end may never come."""
        said = {kind: str(count) for kind, count in missing.items() if count}
        if said != self._said:
            self._file.describe(END, said)
            self._said = said

    def seal(self, missing: Mapping[str, int]) -> None:
        """Write the end of the log; `settle` gives it its name.

        Raises:
            OSError: the disk did not take it.
            LostPlaceError: the file is no longer where it should be: another one must not get its
                name.
        """
        self.say_missing(missing)
        with contextlib.suppress(NoRoomError):  # the reserve is there for this
            self._look()
        self._file.seal()

    def settle(self) -> None:
        """Make it durable and give it its name; from any thread.

        Raises:
            OSError: the disk did not take it, or something of that name is there.
        """
        self._file.file.settle()
        self._is_finished = True

    def finish(self, missing: Mapping[str, int]) -> None:
        """Do both.

        Raises:
            OSError, LostPlaceError: see there.
        """
        self.seal(missing)
        self.settle()

    def end(self) -> None:
        """Finish the log, which keeps the name of an unfinished one.

        Raises:
            OSError: the disk did not take it.
        """
        self._file.end()

    def abandon(self) -> None:
        """Close it as it is, for `recover`."""
        self._file.file.abandon()

    def discard(self) -> None:
        """Close it and remove it."""
        self._file.discard()

    def _look(self) -> str:
        return self._place.look(self.path, self.partial, self._file.file.fileno())

    def _keep_synced(self) -> None:
        """Ask for a sync when one is due, and none is under way."""
        self._hear_of_sync()
        if self._sync is None and time.monotonic() >= self._sync_due_s:
            self._sync = self._syncer.do(self._file.file.sync)

    def _hear_of_sync(self) -> None:
        last = self._sync
        if last is None or not last.is_done:
            return
        if last.error is not None:
            raise last.error
        self._sync = None
        pause_s = max(self._period_s - last.took_s, _SYNC_SHARE * last.took_s)
        self._sync_due_s = time.monotonic() + pause_s


def next_path(first: Path, number: int) -> tuple[Path, int] | None:
    """The name of a part, and its number: the next one that nothing has; None: there are too many.

    `drive.mcap` goes on in `drive.part2.mcap`.
    """
    for candidate in range(number, MAX_PARTS + 1):
        path = first.with_name(f"{first.stem}.part{candidate}{first.suffix}")
        partial = path.with_name(path.name + PARTIAL)
        if not (path.is_symlink() or path.exists() or partial.exists()):
            return path, candidate
    return None


def _compressor_of(run: RunInfo) -> Compressor:
    """What may take only so much time beside a loop in real time; else the same bytes each time."""
    is_beside_a_loop = run.clock != "lockstep" and run.recorded_by != "decide"
    return ThriftyCompressor() if is_beside_a_loop else FixedCompressor()
