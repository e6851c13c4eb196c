"""What a Zenoh configuration shows at a TLS door: authority, certificate, key.

A file of `reflexarc secure init` holds them as base64 in itself, which Zenoh does not tell again;
other files name their files.
"""

import base64
import binascii
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reflexarc_runtime.doors.open_doors import Setting

_TLS = "transport/link/tls"
COMMENT = "//"


@dataclass(frozen=True)
class Credentials:
    """As PEM."""

    authority: bytes
    certificate: bytes
    key: bytes


def parse_zenoh_file(text: str) -> dict[str, Any]:
    """The settings of a file that is JSON between lines of comment, as `secure init` writes it.

    Raises:
        ValueError: it is not.
    """
    lines = text.splitlines()
    settings = json.loads(
        "\n".join(line for line in lines if not line.lstrip().startswith(COMMENT))
    )
    if not isinstance(settings, dict):
        raise ValueError("expected an object")
    return settings


def credentials_of(file: Path, setting: Setting) -> Credentials | None:
    """What a client of this configuration shows; None if it cannot be read here."""
    names = ("root_ca_certificate", "connect_certificate", "connect_private_key")
    try:
        own = _own(file)
        named = setting(_TLS) or {}
        return Credentials(*(_bytes(own.get(f"{n}_base64"), named.get(n)) for n in names))
    except (OSError, ValueError):
        return None


def _own(file: Path) -> dict[str, Any]:
    """The TLS settings of a file of ours; of another one, nothing."""
    try:
        found: Any = parse_zenoh_file(file.read_text(encoding="utf-8"))
    except ValueError:
        return {}
    for part in _TLS.split("/"):
        found = found.get(part) if isinstance(found, dict) else None
    return found if isinstance(found, dict) else {}


def _bytes(encoded: object, path: object) -> bytes:
    if isinstance(encoded, str):
        try:
            return base64.b64decode(encoded, validate=True)
        except binascii.Error as error:
            raise ValueError(str(error)) from None
    if isinstance(path, str):
        return Path(path).read_bytes()
    raise ValueError("none")
