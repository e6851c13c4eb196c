"""Writes to the part that is open, if one is; a disk that fails closes it, the robot goes on."""

from collections.abc import Callable, Mapping

from reflexarc_logs.container.rejected import LogEntry
from reflexarc_logs.recording.part import Part
from reflexarc_logs.recording.place import LostPlaceError, NoRoomError
from reflexarc_logs.recording.recording_account import RecordingAccount
from reflexarc_logs.recording.recording_notices import RecordingNotices
from reflexarc_logs.recording.series import FIRST, Series, in_words


class PartKeeper:
    """The open part of a series, and what is said of it.

    Args:
        series: begins parts.
        account: what is amiss.
    """

    def __init__(self, series: Series, account: RecordingAccount) -> None:
        self._series, self._account = series, account
        self._notices = RecordingNotices()
        self._before = account.left_out()

    @property
    def part(self) -> Part | None:
        """The part that is open."""
        return self._series.current

    def begin_again(
        self, why: Mapping[str, str] = FIRST, before: Mapping[str, int] | None = None
    ) -> bool:
        """Begin a part after a failure, if the disk can take it now; see `begin_next`."""
        account = self._account
        part = self._series.begin(account.failure, account.lost, why)
        if part is None:
            return False
        self._notices.goes_on(part.path, account.lost)
        account.goes_on(part.path.name)
        self._before = account.left_out() if before is None else dict(before)
        return True

    def begin_next(self, about: Mapping[str, str], before: Mapping[str, int] | None = None) -> bool:
        """Begin a part where nothing failed; if the disk refuses it, that is a failure.

        Args:
            about: what it says of itself.
            before: what was left out before it begins; None: as of now.
        """
        part = self._series.go_on(about)
        if part is None:
            self._account.note_failure(self._series.refusal)
            self._notices.refused(self._series.path, self._series.refusal)
            return False
        self._before = self._account.left_out() if before is None else dict(before)
        return True

    def write(self, entry: LogEntry) -> None:
        """Write an entry to the open part."""
        if self.part is not None:
            self.part.write(entry)

    def lose(self) -> None:
        """Count an entry that no part took."""
        self._account.lost += 1

    def keep(self) -> None:
        """Bring all to the disk, look at it, and remove what is too much."""
        if self.part is not None:
            self._account.trouble = self.part.keep(self._missing())
            dropped = self._account.backlog.dropped
            self._notices.look(self.part.path, self._account.trouble, dropped)
        self._hear_of_settled()
        self._series.make_room()

    def finish(self) -> None:
        """Finish the open part; the disk takes its time, and the next one need not wait."""
        if self.part is not None:
            self.part.seal(self._missing())
            self._series.settle()

    def end(self) -> None:
        """Finish the open part, and wait for the disk."""
        try:
            self.finish()
        except Exception as error:
            self.fail(error)
        self._hear_of_settled(wait=True)
        self._series.make_room()
        self._series.close()

    def fail(self, error: Exception) -> None:
        """Close the part that failed, as well as it can be; whatever happens, the robot goes on."""
        part = self.part
        if part is None:
            self._account.note_failure(repr(error))
        elif isinstance(error, NoRoomError):
            self._leave(part, str(error), lambda: part.finish(self._missing()))
        elif isinstance(error, LostPlaceError):
            self._leave(part, str(error), part.end)
        else:
            self._leave(part, in_words(part.sync_error or error), part.abandon)

    def _hear_of_settled(self, *, wait: bool = False) -> None:
        """Parts that did not get their names are failures, though the next one goes on."""
        for part, error in self._series.settled(wait=wait):
            reason = in_words(error)
            self._account.failures.append(reason)
            if self.part is None:
                self._account.failure = reason
            else:
                self._account.again_in = self.part.path.name
            self._notices.unsettled(part.path, reason, part.place_now)

    def _leave(self, part: Part, reason: str, leave: Callable[[], None]) -> None:
        self._account.note_failure(reason)  # at once: leaving a file may take long
        try:
            leave()
        except Exception:  # it failed already; this is for what may still be saved
            part.abandon()
        self._series.failed(reason)
        self._notices.stopped(part.path, reason, part.place_now)

    def _missing(self) -> dict[str, int]:
        """What is missing in the middle of this part."""
        left_out = self._account.left_out()
        return {kind: count - self._before[kind] for kind, count in left_out.items()}
