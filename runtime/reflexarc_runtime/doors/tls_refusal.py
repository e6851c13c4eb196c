"""Why a TLS door stays shut, in words: Zenoh says of each reason only that it could not connect.

A handshake with Python's own TLS, which shows the same certificate to the same door, tells. In TLS
1.3 a server refuses a client's certificate after the client's handshake has ended: the alert comes
with the first read.
"""

import os
import socket
import ssl
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from reflexarc_runtime.doors.credentials import Credentials
from reflexarc_runtime.errors import first_line

ANSWER_S = 1.0
"""How long an alert is waited for; a door that opens waits for us to speak."""
HANDSHAKE_S = 4.0
"""How long a handshake may take, on a machine that is busy."""

_RENEW = "`reflexarc secure renew` where the authority is, and copy the file anew"
_SAME = "take both files of one `reflexarc secure init`"
_BY_CODE = {
    9: f"its certificate is not valid yet: are both clocks right? Else {_RENEW}",
    10: f"its certificate has expired: {_RENEW} (and are both clocks right?)",
    26: f"its certificate is none of a door, but of another role: {_SAME}",
    62: "its certificate is for other names: `reflexarc secure init --host` with this one",
    64: "its certificate is for other addresses: `reflexarc secure init --host` with this one",
}
"""By OpenSSL's X509_V_ERR numbers; every other one says that we do not know who signed it."""
_BY_ALERT = {
    "CERTIFICATE_EXPIRED": (
        f"it says that our certificate has expired, or is not valid yet: {_RENEW} "
        "(and are both clocks right?)"
    ),
    "CERTIFICATE_REQUIRED": "it asks for a certificate, and this configuration shows none",
    "UNKNOWN_CA": f"it does not know who signed our certificate: {_SAME}",
    "DECRYPT_ERROR": f"our certificate is signed by another authority of the same name: {_SAME}",
    "BAD_CERTIFICATE": f"it refuses our certificate: {_SAME}",
    "CERTIFICATE_UNKNOWN": f"it refuses our certificate: {_SAME}",
    "WRONG_VERSION_NUMBER": "it speaks no TLS: is it another program, or a plain listener?",
    "RECORD_LAYER_FAILURE": "it speaks no TLS: is it another program, or a plain listener?",
}


@dataclass(frozen=True)
class DoorRefusal:
    """Why a door stays shut."""

    words: str
    may_pass: bool
    """Whether waiting may mend it: there is no door yet, or its program hangs."""


_SILENT = DoorRefusal(
    "it takes the connection and says nothing: is it a plain listener, or does it hang?", True
)
"""A plain Zenoh listener takes the first bytes for a length, waits for so many, and ends later."""
_WORDLESS = DoorRefusal(
    "it ends the connection without a word: is it another program, or a plain listener?", False
)


def why_refused(host: str, port: int, shown: Credentials) -> DoorRefusal | None:
    """Knock at a door; None if it would open."""
    try:
        with _context(shown) as context:
            refusal = _knock(host, port, context)
            if refusal in (_SILENT, _WORDLESS):  # so does a door whose program is just ending
                refusal = _knock(host, port, context)
            return refusal
    except (ssl.SSLError, ValueError, TypeError) as error:  # OpenSSL, and what reads for it
        return DoorRefusal(f"certificate or key cannot be used: {first_line(error)}", False)


def _knock(host: str, port: int, context: ssl.SSLContext) -> DoorRefusal | None:
    try:
        plain = socket.create_connection((host, port), ANSWER_S)
    except OSError as error:
        return DoorRefusal(f"nobody listens there ({error.strerror or first_line(error)})", True)
    except UnicodeError as error:
        return DoorRefusal(f"no host can be called so: {first_line(error)}", False)
    with plain:
        return _shake_hands(plain, host, context)


def _shake_hands(plain: socket.socket, host: str, context: ssl.SSLContext) -> DoorRefusal | None:
    """Somebody is there: whatever goes wrong from here on is no absence."""
    plain.settimeout(HANDSHAKE_S)
    try:
        with context.wrap_socket(plain, server_hostname=host) as door:
            door.settimeout(ANSWER_S)
            return _answer(door)
    except ssl.SSLCertVerificationError as error:
        other = f"its certificate is signed by another authority: {_SAME}"
        return DoorRefusal(_BY_CODE.get(error.verify_code, other), False)
    except ssl.SSLEOFError:
        return _WORDLESS
    except ssl.SSLError as error:
        return DoorRefusal(_alert(error), False)
    except TimeoutError:
        return _SILENT
    except OSError:
        return _WORDLESS


def _answer(door: ssl.SSLSocket) -> DoorRefusal | None:
    """An alert, an end, or silence, which is consent."""
    try:
        return None if door.recv(1) else DoorRefusal("it ends the connection", False)
    except TimeoutError:
        return None


def _alert(error: ssl.SSLError) -> str:
    reason = error.reason or ""
    for name, words in _BY_ALERT.items():
        if name in reason:
            return words
    return f"it refuses the connection: {first_line(error)}"


@contextmanager
def _context(shown: Credentials) -> Iterator[ssl.SSLContext]:
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    # Around the certificates anything may stand, a name in any language too.
    context.load_verify_locations(cadata=shown.authority.decode("ascii", "ignore"))
    with _in_memory(shown.certificate + b"\n" + shown.key) as path:
        context.load_cert_chain(path)
    yield context


@contextmanager
def _in_memory(secret: bytes) -> Iterator[str]:
    """A file that no disk ever holds: Python's TLS reads keys from files alone."""
    handle = os.memfd_create("key", os.MFD_CLOEXEC)
    try:
        os.write(handle, secret)
        yield f"/proc/self/fd/{handle}"
    finally:
        os.close(handle)
