"""The folder of `reflexarc secure`: whole or absent, read by its owner alone.

`ca.pem` and `ca.key` are the authority, `secured.json` what it was made for, and `<role>.json5` the
Zenoh configuration of each role.
"""

import os
import shutil
import stat
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from reflexarc.securing.authority import Authority, Identity, Validity
from reflexarc.securing.renewing import renewed
from reflexarc.securing.secured_robot import SecuredRobot, parse_secured_robot
from reflexarc_runtime.errors import UsageError, first_line

AUTHORITY, AUTHORITY_KEY, SETTINGS = "ca.pem", "ca.key", "secured.json"
FOLDER_MODE, SECRET_MODE, PUBLIC_MODE = 0o700, 0o600, 0o644
AUTHORITY_LIVES_LONGER = 10
"""The authority holds so many times longer than a certificate: a renewal needs no new one."""


@dataclass(frozen=True)
class SecurityFolder:
    """A folder that `secure init` made."""

    path: Path

    def file(self, role: str) -> Path:
        """The configuration of a role."""
        return self.path / f"{role}.json5"

    @property
    def known(self) -> bytes:
        """The authority's certificate."""
        return _read(self.path / AUTHORITY)

    @property
    def has_authority(self) -> bool:
        """Whether the authority's key is here, and not kept elsewhere."""
        return (self.path / AUTHORITY_KEY).exists()

    def secured(self) -> SecuredRobot:
        """What it was made for.

        Raises:
            UsageError: it is no such folder.
        """
        file = self.path / SETTINGS
        try:
            return parse_secured_robot(_read(file).decode())
        except ValueError as error:
            raise UsageError(f"{file}: expected what `secure init` wrote: {error}") from None

    def authority(self) -> Authority:
        """The authority that signs.

        Raises:
            UsageError: its key is not here, or none.
        """
        try:
            return Authority.of_pem(self.known, _read(self.path / AUTHORITY_KEY))
        except (ValueError, TypeError) as error:
            raise UsageError(f"{self.path}: {AUTHORITY_KEY}: {first_line(error)}") from None

    @property
    def secrets(self) -> list[Path]:
        """The files with keys that are here."""
        return sorted({*self.path.glob("*.json5"), *self.path.glob("*.key")})

    def readable_by_others(self) -> list[str]:
        """Names of what others than the owner could read."""
        beyond = stat.S_IRWXG | stat.S_IRWXO
        return [file.name for file in self.secrets if file.stat().st_mode & beyond]


def make_folder(path: Path, secured: SecuredRobot) -> SecurityFolder:
    """Make authority, certificates and configurations: all of them, or nothing.

    Raises:
        UsageError: there is something already.
    """
    if path.exists() or path.is_symlink():
        raise UsageError(
            f"{path}: expected a folder that is not there yet, found one: nothing is overwritten; "
            "`reflexarc secure renew` makes new certificates in it"
        )
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = Path(tempfile.mkdtemp(dir=path.parent, prefix=f".{path.name}."))  # mode 0700
    try:
        _fill(unfinished, secured)
        os.rename(unfinished, path)  # refuses a folder that somebody filled meanwhile
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)
    return SecurityFolder(path)


def _fill(folder: Path, secured: SecuredRobot) -> None:
    lives = Validity.of_days(secured.days * AUTHORITY_LIVES_LONGER)
    authority = Authority.made(f"reflexarc authority of {secured.robot}"[:64], lives)
    own = authority.identity
    _write(folder / AUTHORITY, own.certificate, PUBLIC_MODE)
    _write(folder / AUTHORITY_KEY, own.key, SECRET_MODE)
    _write(folder / SETTINGS, secured.as_json().encode(), PUBLIC_MODE)
    for role in secured.roles:
        text = role_text(secured, role, authority, Validity.of_days(secured.days))
        _write(folder / f"{role}.json5", text.encode(), SECRET_MODE)


def renew(folder: SecurityFolder, days: float | None, roles: Iterable[str] = ()) -> list[Path]:
    """New certificates and keys by the same authority; each file is the old or the new one.

    All else in a file stays, rights that were added by hand too; one that is gone is made again.

    Args:
        folder: where the authority is.
        days: how long they hold; None: as before.
        roles: whose; empty: everybody's.

    Returns:
        The files that are new.

    Raises:
        UsageError: a role that there is not, or a file in which they cannot be found; none is new.
    """
    secured, authority = folder.secured(), folder.authority()
    if days is not None:
        secured = replace(secured, days=days)
    asked = tuple(roles) or secured.roles
    strange = [role for role in asked if role not in secured.roles]
    if strange:
        wanted = ", ".join(secured.roles)
        raise UsageError(f"--role: expected {wanted}, got {', '.join(strange)}")
    valid = Validity.of_days(secured.days)
    fresh = {folder.file(r): role_text(secured, r, authority, valid) for r in asked}
    texts = {file: _renewed(file, text) for file, text in fresh.items()}
    for file, text in texts.items():
        _replace(file, text.encode(), SECRET_MODE)
    return list(texts)


def _renewed(file: Path, fresh: str) -> str:
    try:
        return renewed(file.read_text(encoding="utf-8"), fresh)
    except FileNotFoundError:
        return fresh
    except ValueError as error:
        raise UsageError(
            f"{file}: {error}, so nothing is renewed; move the file away, and it is made again "
            "without what was added by hand"
        ) from None


def role_text(secured: SecuredRobot, role: str, authority: Authority, valid: Validity) -> str:
    """The file of a role, with a new certificate."""
    own: Identity = secured.identity(role, authority, valid)
    return secured.text(role, authority.identity.certificate, own)


def _write(path: Path, data: bytes, mode: int) -> None:
    """Write a file that nobody else could read for a moment, and that is on the disk."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode)
    with os.fdopen(handle, "wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _replace(path: Path, data: bytes, mode: int) -> None:
    unfinished = path.with_name(f".{path.name}.new")
    unfinished.unlink(missing_ok=True)
    _write(unfinished, data, mode)
    os.replace(unfinished, path)


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise UsageError(
            f"{path}: {(error.strerror or '').lower()}; `reflexarc secure init` makes it"
        ) from None
