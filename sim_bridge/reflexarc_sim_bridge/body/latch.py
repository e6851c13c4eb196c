"""A stop that outlives the body: a small file with the reason, there while the stop holds."""

import logging
from pathlib import Path
from urllib.parse import quote

from reflexarc_runtime.files import write_atomically

_LOG = logging.getLogger(__name__)


class StopLatch:
    """Keeps the reason of a stop on the disk, so that a body that begins again still stands.

    Args:
        folder: where the file is; made when there is something to keep.
        robot: whose stop it is.
    """

    def __init__(self, folder: Path, robot: str) -> None:
        self.path = folder / f"{quote(robot, safe='')}.stopped"
        self._kept = self._read()

    @property
    def stopped(self) -> str:
        """The reason of the stop that holds; empty without one."""
        return self._kept

    def keep(self, stopped: str) -> None:
        """Keep a reason, or none; a disk that cannot is said and changes nothing else."""
        if stopped == self._kept:
            return
        self._kept = stopped
        try:
            if stopped:
                write_atomically(self.path, stopped.encode())
            else:
                self.path.unlink(missing_ok=True)
        except OSError as error:
            _LOG.warning("%s: the stop will not outlive this process: %s", self.path, error)

    def _read(self) -> str:
        """A file that is there stops, whatever is in it."""
        try:
            said = self.path.read_bytes().decode(errors="replace")
            return said[:200] or "a stop without a reason"
        except FileNotFoundError:
            return ""
        except OSError as error:
            return f"{self.path} cannot be read: {error.strerror}"
