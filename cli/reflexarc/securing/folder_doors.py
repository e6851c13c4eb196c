"""What can be seen of a folder's doors without opening one: files, certificates, settings."""

import base64
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

from cryptography import x509
from cryptography.exceptions import InvalidSignature

from reflexarc.securing.door_row import DoorRow, DoorState, row
from reflexarc.securing.security_folder import SecurityFolder
from reflexarc.securing.variants import settings_of
from reflexarc_runtime.doors.open_doors import listeners, open_doors
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_runtime.messages.access import common_name

SOON = timedelta(days=30)


def folder_rows(folder: SecurityFolder, now: datetime | None = None) -> Iterator[DoorRow]:
    """What is seen in the folder itself."""
    secured, now = folder.secured(), now or datetime.now(UTC)
    here = [role for role in secured.roles if folder.file(role).exists()]
    loose = [f"{name} can be read by others: chmod 600" for name in folder.readable_by_others()]
    yield row("key files", loose, f"{len(folder.secrets)} of them, read by their owner alone")
    for role in here:
        yield _certificate_row(folder, role, common_name(role, secured.robot), now)
    settings = _settings_row(folder, here)
    yield settings
    if secured.door in here and settings.state is not DoorState.BROKEN:
        yield _rights_row(folder, secured.door)


def _certificate_row(folder: SecurityFolder, role: str, name: str, now: datetime) -> DoorRow:
    door = f"certificate of {role}"
    try:
        certificate = _certificate(folder, role)
    except (UsageError, ValueError) as error:
        return DoorRow(door, DoorState.BROKEN, f"cannot be read: {error}")
    wrong = list(_faults(certificate, folder.known, name, now))
    end = certificate.not_valid_after_utc
    left = f"valid until {end:%Y-%m-%d}"
    if end - now < SOON:
        left += ", which is soon: `reflexarc secure renew`"
    return DoorRow(door, DoorState.BROKEN if wrong else DoorState.SHUT, "; ".join(wrong) or left)


def _certificate(folder: SecurityFolder, role: str) -> x509.Certificate:
    shown = settings_of(folder, role)["transport"]["link"]["tls"].get("connect_certificate_base64")
    if not isinstance(shown, str):
        raise UsageError(f"{folder.file(role)}: it holds no certificate")
    return x509.load_pem_x509_certificate(base64.b64decode(shown))


def _faults(own: x509.Certificate, known: bytes, name: str, now: datetime) -> Iterator[str]:
    if now > own.not_valid_after_utc:
        yield f"has expired on {own.not_valid_after_utc:%Y-%m-%d %H:%M} UTC: `secure renew`"
    if now < own.not_valid_before_utc:
        yield f"is valid only from {own.not_valid_before_utc:%Y-%m-%d %H:%M} UTC: the clock?"
    if own.subject.rfc4514_string() != f"CN={name}":
        yield f"expected CN={name}, got {own.subject.rfc4514_string()}"
    try:
        own.verify_directly_issued_by(x509.load_pem_x509_certificate(known))
    except (InvalidSignature, ValueError, TypeError):
        yield "is not signed by ca.pem: another authority"


def _settings_row(folder: SecurityFolder, roles: list[str]) -> DoorRow:
    """Plain listeners and multicast, as Zenoh resolves each file."""
    found, places = [], []
    for role in roles:
        try:
            setting = _settings_of(folder.file(role))
        except ReflexarcError as error:
            return DoorRow("listeners, multicast", DoorState.BROKEN, str(error))
        found += [f"{role}.json5 {words}" for words in open_doors(setting)]
        places += listeners(setting)
    where = ", ".join(places) or "nowhere"
    return row("listeners, multicast", found, f"no plain listener, no multicast; TLS on {where}")


def _rights_row(folder: SecurityFolder, door: str) -> DoorRow:
    setting = _settings_of(folder.file(door))
    rights, tls = setting("access_control") or {}, setting("transport/link/tls") or {}
    found = []
    if not rights.get("enabled") or rights.get("default_permission") != "deny":
        found.append("access_control: expected enabled, and deny by default")
    if tls.get("verify_name_on_connect") is False:
        found.append("verify_name_on_connect is off: any certificate passes for a door")
    return row("access control", found, "denies what no rule allows; names of hosts are checked")


def _settings_of(file: Path) -> Any:
    """What Zenoh makes of a file; only here is it loaded."""
    from reflexarc_runtime.bus import settings_of_file

    return settings_of_file(file)
