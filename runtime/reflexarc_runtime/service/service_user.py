"""Whom a service runs as, and what that user may reach, by the modes of files and folders.

As in path_resolution(7) and inode(7): every folder on the way must be open to him, `x`, then the
file itself. The unit leaves nobody a capability, so that root as well may do only what modes say.
"""

import os
import pwd
import stat
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.errors import UsageError

READ, WRITE, ENTER = 4, 2, 1
_ACL = "system.posix_acl_access"


@dataclass(frozen=True)
class ServiceUser:
    """A user of this machine, or one that systemd makes, who owns nothing and is in no group."""

    name: str = ""
    uid: int | None = None
    groups: frozenset[int] = frozenset()

    @property
    def words(self) -> str:
        """Who it is."""
        return self.name or "the user that systemd makes for the service"

    def obstacle(self, path: Path, wanted: int) -> str:
        """What keeps it from a file or folder, in words; empty if nothing does.

        Args:
            path: of the file, absolute.
            wanted: `READ`, `WRITE` and `ENTER`, added.
        """
        for place, needs in _way(path, wanted):
            try:
                status = place.stat()
            except (OSError, ValueError) as error:
                return f"{place}: {getattr(error, 'strerror', None) or error}".lower()
            if not self._may(place, status, needs):
                return f"{place} is closed to it (mode {stat.S_IMODE(status.st_mode):04o})"
        return ""

    def _may(self, place: Path, status: os.stat_result, needs: int) -> bool:
        mode = status.st_mode
        if self.uid == status.st_uid:
            return (mode >> 6) & needs == needs
        if self.name and _has_list(place):
            return True  # a list of its own says who may; it is not read here
        shift = 3 if status.st_gid in self.groups else 0
        return (mode >> shift) & needs == needs


def service_user_of(user: str) -> ServiceUser:
    """A user by name or number; empty: one that systemd makes.

    Raises:
        UsageError: there is none.
    """
    if not user:
        return ServiceUser()
    try:
        found = pwd.getpwuid(int(user)) if user.isdecimal() else pwd.getpwnam(user)
    except (KeyError, OverflowError):
        raise UsageError(
            f"--user: expected a user of this machine, got {user!r}; `useradd --system` makes one"
        ) from None
    groups = os.getgrouplist(found.pw_name, found.pw_gid)
    return ServiceUser(found.pw_name, found.pw_uid, frozenset(groups))


def _way(path: Path, wanted: int) -> Iterator[tuple[Path, int]]:
    """Every folder on the way, as it is written and where its links lead to; then the end."""
    written, real = path.absolute(), Path(os.path.realpath(path))
    for folder in dict.fromkeys((*reversed(written.parents), *reversed(real.parents))):
        yield folder, ENTER
    yield real, wanted


def _has_list(place: Path) -> bool:
    try:
        return bool(os.getxattr(place, _ACL))
    except OSError:
        return False
