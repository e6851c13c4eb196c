"""Says on the terminal what is amiss with a recording, once a change."""

import logging
from pathlib import Path

_LOG = logging.getLogger("reflexarc_logs.recording")


class RecordingNotices:
    """Remembers what was said."""

    def __init__(self) -> None:
        self._trouble = ""
        self._dropped = 0

    def look(self, path: Path, trouble: str, dropped: int) -> None:
        """Say what keeps a log from getting its name, and how much was dropped, if that is new."""
        if trouble and trouble != self._trouble:
            _LOG.warning("%s: %s: it will stay unfinished", path, trouble)
        if dropped > self._dropped:
            _LOG.error("%s: the disk is too slow: %d records dropped", path, dropped)
        self._trouble, self._dropped = trouble, dropped

    def stopped(self, path: Path, reason: str, kept: Path) -> None:
        """Say that nothing is recorded any more."""
        where = f"What was written is in {kept}" if kept.exists() else "What was written is gone"
        _LOG.error("%s: the recording stopped: %s; the robot goes on. %s", path, reason, where)

    def unsettled(self, path: Path, reason: str, kept: Path) -> None:
        """Say that a part that was written to its end did not get its name."""
        _LOG.error("%s: could not be finished: %s. What was written is in %s", path, reason, kept)

    def refused(self, path: Path, reason: str) -> None:
        """Say that the next part could not be begun."""
        _LOG.error("%s: the next part cannot be begun: %s; the robot goes on", path, reason)

    def goes_on(self, path: Path, lost: int) -> None:
        """Say that a new part began."""
        _LOG.warning("%s: the recording goes on; %d records were lost before it", path, lost)
