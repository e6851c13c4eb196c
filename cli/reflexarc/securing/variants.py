"""Configurations that differ in one thing from those of a folder, to try a door with."""

import copy
import json
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from reflexarc.securing.authority import Identity
from reflexarc.securing.secured_robot import ONCE, base64_of
from reflexarc.securing.security_folder import SecurityFolder
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.doors.credentials import parse_zenoh_file
from reflexarc_runtime.errors import UsageError, first_line
from reflexarc_runtime.loop.clock import MonotonicClock

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

Settings = dict[str, Any]


def settings_of(folder: SecurityFolder, role: str) -> Settings:
    """What the file of a role says.

    Raises:
        UsageError: it cannot be read, or is none that `secure init` wrote.
    """
    file = folder.file(role)
    try:
        settings = parse_zenoh_file(file.read_text(encoding="utf-8"))
        _check_shape(settings)
    except OSError as error:
        raise UsageError(f"{file}: cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise UsageError(
            f"{file}: expected JSON between lines of comment, as `secure init` wrote it: "
            f"{first_line(error)}"
        ) from None
    return settings


def _check_shape(settings: Settings) -> None:
    """Look at what is varied here; Zenoh itself looks at the rest.

    Raises:
        ValueError: it is of another shape.
    """
    place: Any = settings
    for part in ("transport", "link", "tls"):
        place = place.get(part)
        if not isinstance(place, dict):
            raise ValueError(f"expected an object at transport.link.tls, got none at {part}")
    for key in ("connect", "listen"):
        if not isinstance(settings.get(key, {}), dict):
            raise ValueError(f"expected an object at {key}")


def listening(settings: Settings, port: int) -> Settings:
    """The same door, at a port of the loopback."""
    changed = copy.deepcopy(settings)
    changed["listen"] = {"endpoints": [f"tls/127.0.0.1:{port}"]}
    return changed


def connecting(settings: Settings, locator: str) -> Settings:
    """The same guest, at another door."""
    changed = copy.deepcopy(settings)
    changed["connect"] = {**changed.get("connect", {}), "endpoints": [locator]}
    changed["connect"]["timeout_ms"] = ONCE
    return changed


def showing(settings: Settings, own: Identity | None) -> Settings:
    """The same guest with another certificate, or with none."""
    changed = copy.deepcopy(settings)
    tls = changed["transport"]["link"]["tls"]
    for part in ("certificate", "private_key"):
        tls.pop(f"connect_{part}_base64", None)
    if own is None:
        tls["enable_mtls"] = False
    else:
        tls["connect_certificate_base64"] = base64_of(own.certificate)
        tls["connect_private_key_base64"] = base64_of(own.key)
    return changed


def plainly(locator: str) -> Settings:
    """A guest that speaks TCP alone, to the same address."""
    address = locator.partition("/")[2]
    return {
        "mode": "client",
        "connect": {"endpoints": [f"tcp/{address}"], "timeout_ms": ONCE},
        "scouting": {"multicast": {"enabled": False}},
    }


@contextmanager
def session(robot: str, settings: Settings, sender: bytes | None = None) -> "Iterator[Bus]":
    """A session with a configuration that is on the disk only until it is read.

    Raises:
        BusError: it does not open.
    """
    from reflexarc_runtime.bus import Bus

    with tempfile.TemporaryDirectory(prefix="reflexarc-") as folder:  # of mode 0700
        file = Path(folder) / "zenoh.json5"
        file.write_text(json.dumps(settings), encoding="utf-8")
        bus = Bus(BusConfig(robot, zenoh_file=file), MonotonicClock().now_ns, sender)
    with bus:
        yield bus
