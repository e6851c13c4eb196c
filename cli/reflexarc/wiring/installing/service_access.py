"""Whether a service may read what it needs, as the user that its unit names: else it never starts.

Looked at before the unit is written, since systemd says of it only 203/EXEC, 226/NAMESPACE, or the
loop itself "permission denied", at each start.
"""

import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.service.service_user import ENTER, READ, WRITE, ServiceUser, service_user_of

if TYPE_CHECKING:
    from reflexarc_runtime.service.unit import ServiceUnit

Need = tuple[str, Path, int]
"""What it is called, where it is, and what is done with it."""

PRIVATE = (Path("/tmp"), Path("/var/tmp"))
"""The unit has these for itself (PrivateTmp): what is there now it does not see."""
_KEYS = (
    "root_ca_certificate",
    "connect_certificate",
    "connect_private_key",
    "listen_certificate",
    "listen_private_key",
)


def check_access(
    unit: "ServiceUnit", config: Path, policies: Mapping[str, Path | None], key: Path | None
) -> None:
    """Check that the user of a service may read what it runs, and write where it records.

    Args:
        unit: of the service.
        config: the file of its settings.
        policies: those that are loaded, by what names them there.
        key: by which they have to be signed; None: they need not be.

    Raises:
        UsageError: there is no such user, or it may not; the line says what to do.
    """
    user = service_user_of(unit.user)
    for what, path, wanted in _needs(unit, config, policies, key):
        hidden = _private(path)
        if hidden:
            raise UsageError(f"{what}: {path}: {hidden}: nothing there is seen; put it elsewhere")
        obstacle = user.obstacle(path, wanted)
        if obstacle:
            raise UsageError(_refusal(what, path, user, wanted, obstacle))


def _refusal(what: str, path: Path, user: ServiceUser, wanted: int, obstacle: str) -> str:
    verb = "write to" if wanted & WRITE else "run" if what == "interpreter" else "read"
    remedy = "install" if what in ("interpreter", "reflexarc") else "put"
    return (
        f"{what}: {path}: {user.words} cannot {verb} it: {obstacle}; {remedy} it where it can, "
        "or name its owner: --user NAME"
    )


def _needs(
    unit: "ServiceUnit", config: Path, policies: Mapping[str, Path | None], key: Path | None
) -> Iterator[Need]:
    yield "interpreter", Path(unit.command[0]), READ | ENTER
    for room in ("reflexarc", "reflexarc_runtime"):
        yield "reflexarc", Path(str(sys.modules[room].__file__)), READ
    yield "config", config, READ
    yield from _policy_files(policies, key)
    if unit.zenoh is not None:
        yield from _zenoh_files(unit.zenoh, is_handed_over=bool(unit.credential))
    for folder in unit.writes:
        yield "--writes", folder, WRITE | ENTER


def _policy_files(policies: Mapping[str, Path | None], key: Path | None) -> Iterator[Need]:
    from reflexarc_runtime.policy.acceptance import signature_path

    for what, policy in policies.items():
        if policy is not None:
            yield what, policy, READ
            if key is not None:
                yield what, signature_path(policy), READ
    if key is not None:
        yield "require-signature", key, READ


def _zenoh_files(zenoh: Path, *, is_handed_over: bool) -> Iterator[Need]:
    """The configuration, unless systemd hands it over, and the keys that it only names."""
    from reflexarc_runtime.bus import settings_of_file

    if not is_handed_over:
        yield "zenoh", zenoh, READ
    named = settings_of_file(zenoh)("transport/link/tls") or {}
    for key in _KEYS:
        path = named.get(key)
        if isinstance(path, str) and not os.path.isabs(path):
            raise UsageError(
                f"zenoh: {zenoh}: {key}: expected an absolute path, as the service runs in a "
                f"folder of its own; got {path!r}"
            )
        if isinstance(path, str):
            yield f"zenoh: {key}", Path(path), READ


def _private(path: Path) -> str:
    real = Path(os.path.realpath(path))
    hidden = next((place for place in PRIVATE if real.is_relative_to(place)), None)
    return "" if hidden is None else f"the service has a {hidden} of its own"
