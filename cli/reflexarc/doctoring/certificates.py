"""The certificate that a Zenoh configuration shows: how long it holds, and who can read it."""

from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc_runtime.errors import ReflexarcError, first_line

_NAME = "certificate"
SOON_DAYS = 30.0
_RENEW = "reflexarc secure renew, where the authority is"


def check_certificates(zenoh: Path) -> Iterator[CheckRow]:
    """All that is said of it."""
    from reflexarc_runtime.bus import settings_of_file
    from reflexarc_runtime.doors.credentials import credentials_of

    try:
        credentials = credentials_of(zenoh, settings_of_file(zenoh))
        mode = zenoh.stat().st_mode
    except (OSError, ReflexarcError) as error:
        yield unknown(_NAME, first_line(error))
        return
    yield judge_mode(mode)
    if credentials is None:
        yield unknown(_NAME, f"{zenoh} names none that can be read here")
        return
    yield _dates(credentials.certificate)


def judge_mode(mode: int) -> CheckRow:
    """Who may read the file, which holds a secret key."""
    found = f"mode {mode & 0o777:04o}"
    if mode & 0o077 == 0:
        return well("key", found)
    why = "others on this machine can read the key, and be this robot"
    return CheckRow("key", Health.MIND, found, why, "chmod 600")


def judge_dates(name: str, begins: datetime, ends: datetime, now: datetime) -> CheckRow:
    """For how long it holds."""
    days = (ends - now).total_seconds() / 86400
    if now < begins:
        found, why = f"{name}: not valid before {begins:%Y-%m-%d}", "no door opens for it yet"
        return CheckRow(_NAME, Health.BAD, found, why, f"is the clock right? Else {_RENEW}")
    if days <= 0:
        found = f"{name}: expired {ends:%Y-%m-%d}"
        return CheckRow(_NAME, Health.BAD, found, "no door opens for it any more", _RENEW)
    found = f"{name}: {days:.0f} days left"
    if days >= SOON_DAYS:
        return well(_NAME, found)
    return CheckRow(_NAME, Health.MIND, found, "then no door opens for it", _RENEW)


def _dates(certificate: bytes) -> CheckRow:
    try:
        from cryptography import x509
        from cryptography.x509.oid import NameOID
    except ImportError:
        return unknown(_NAME, "needs pip install 'reflexarc[secure]'")
    try:
        found = x509.load_pem_x509_certificate(certificate)
    except ValueError as error:
        return CheckRow(_NAME, Health.BAD, first_line(error), "no door opens for it", _RENEW)
    names = found.subject.get_attributes_for_oid(NameOID.COMMON_NAME)
    name = str(names[0].value) if names else "without a name"
    return judge_dates(
        name, found.not_valid_before_utc, found.not_valid_after_utc, datetime.now(UTC)
    )
