"""Each reason in words, at a TLS server of Python's own."""

import socket
import struct
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

pytest.importorskip("cryptography")

from reflexarc.securing.authority import Authority, Identity, Validity
from reflexarc_runtime.doors import tls_refusal
from reflexarc_runtime.doors.credentials import Credentials
from reflexarc_runtime.doors.tls_refusal import why_refused
from support.tls_server import tls_server

HOSTS = ("127.0.0.1", "localhost")


def days(first: float, last: float) -> Validity:
    now = datetime.now(UTC)
    return Validity(now + timedelta(days=first), now + timedelta(days=last))


NOW = days(-1, 1)
AUTHORITY = Authority.made("authority", days(-10, 10))
NAMESAKE = Authority.made("authority", days(-10, 10))
STRANGER = Authority.made("another", days(-10, 10))
DOOR = AUTHORITY.issue("body.robot0", NOW, HOSTS)
GUEST = AUTHORITY.issue("runtime.robot0", NOW)


@pytest.fixture(autouse=True)
def silence_is_short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tls_refusal, "ANSWER_S", 0.3)
    monkeypatch.setattr(tls_refusal, "HANDSHAKE_S", 0.3)


def knocked(door: Identity, guest: Identity, folder: Path, known: Authority = AUTHORITY) -> str:
    shown = Credentials(known.identity.certificate, guest.certificate, guest.key)
    with tls_server(door, AUTHORITY.identity.certificate, folder) as port:
        refusal = why_refused("127.0.0.1", port, shown)
    assert refusal is None or not refusal.may_pass
    return "" if refusal is None else refusal.words


def test_the_right_certificate_opens(tmp_path: Path):
    assert knocked(DOOR, GUEST, tmp_path) == ""


@pytest.mark.parametrize(
    ("guest", "words"),
    [
        (AUTHORITY.issue("runtime.robot0", days(-3, -2)), "our certificate has expired"),
        (STRANGER.issue("runtime.robot0", NOW), "does not know who signed our certificate"),
        (NAMESAKE.issue("runtime.robot0", NOW), "who signed our certificate"),
    ],
    ids=["expired", "strange", "forged"],
)
def test_a_guest_that_is_refused_is_told_why(guest: Identity, words: str, tmp_path: Path):
    assert words in knocked(DOOR, guest, tmp_path)


@pytest.mark.parametrize(
    ("door", "words"),
    [
        (AUTHORITY.issue("body.robot0", days(-3, -2), HOSTS), "its certificate has expired"),
        (AUTHORITY.issue("body.robot0", days(2, 3), HOSTS), "not valid yet"),
        (AUTHORITY.issue("body.robot0", NOW, ("elsewhere.invalid",)), "for other addresses"),
        (AUTHORITY.issue("runtime.robot0", NOW), "is none of a door"),
    ],
    ids=["expired", "early", "misnamed", "guest"],
)
def test_a_door_that_is_refused_is_told_why(door: Identity, words: str, tmp_path: Path):
    assert words in knocked(door, GUEST, tmp_path)


def test_a_door_of_another_authority_is_refused(tmp_path: Path):
    assert "signed by another authority" in knocked(DOOR, GUEST, tmp_path, known=STRANGER)


def test_nobody_there_is_an_absence_and_plain_words_are_none():
    shown = Credentials(AUTHORITY.identity.certificate, GUEST.certificate, GUEST.key)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    refusal = why_refused("127.0.0.1", port, shown)
    assert refusal is not None
    assert refusal.may_pass


def test_a_key_that_is_none_is_said():
    shown = Credentials(AUTHORITY.identity.certificate, b"no", b"key")
    refusal = why_refused("127.0.0.1", 9, shown)
    assert refusal is not None
    assert "cannot be used" in refusal.words


SHOWN = Credentials(AUTHORITY.identity.certificate, GUEST.certificate, GUEST.key)


@contextmanager
def listener_that(meets: Callable[[socket.socket], None], times: int) -> Iterator[int]:
    """Accept so many connections, one after the other; then nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port: int = listener.getsockname()[1]
        listener.settimeout(3.0)

        def serve() -> None:
            for k in range(times):
                try:
                    plain, _ = listener.accept()
                except TimeoutError:  # nobody knocks again
                    return
                if k == times - 1:
                    listener.close()
                meets(plain)

        thread = threading.Thread(target=serve)
        thread.start()
        yield port
        thread.join()


def silent(plain: socket.socket) -> None:
    """What a plain Zenoh listener does: it waits for more than a handshake begins with."""
    with plain:
        while plain.recv(4096):
            pass


def reset(plain: socket.socket) -> None:
    plain.recv(1)
    plain.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    plain.close()


def closed(plain: socket.socket) -> None:
    with plain:
        plain.recv(4096)


@pytest.mark.parametrize(
    ("meets", "words", "may_pass"),
    [
        (silent, "says nothing", True),  # a body that hangs may go on
        (reset, "without a word", False),
        (closed, "without a word", False),
    ],
)
def test_a_plain_listener_is_there_and_no_door(
    meets: Callable[[socket.socket], None], words: str, *, may_pass: bool
):
    with listener_that(meets, times=2) as port:
        refusal = why_refused("127.0.0.1", port, SHOWN)
    assert refusal is not None
    assert refusal.may_pass is may_pass
    assert words in refusal.words
    assert "a plain listener" in refusal.words


def test_a_door_that_ends_amid_a_handshake_is_an_absence():
    """Whoever waits for a robot whose body is just ending goes on waiting."""
    with listener_that(reset, times=1) as port:
        refusal = why_refused("127.0.0.1", port, SHOWN)
    assert refusal is not None
    assert refusal.may_pass


@pytest.mark.parametrize("host", ["rover..local", "x" * 64, ".local"])
def test_a_name_that_no_host_has_is_said(host: str):
    refusal = why_refused(host, 9, SHOWN)
    assert refusal is not None
    assert not refusal.may_pass
    assert "no host can be called so" in refusal.words


def test_what_stands_around_certificates_does_no_harm(tmp_path: Path):
    known = "# Zertifizierungsstelle für Grünau\n".encode() + AUTHORITY.identity.certificate
    shown = Credentials(known, GUEST.certificate, GUEST.key)
    with tls_server(DOOR, AUTHORITY.identity.certificate, tmp_path) as port:
        assert why_refused("127.0.0.1", port, shown) is None


@pytest.mark.parametrize("known", [b"", b"none", "für".encode(), b"\x00"])
def test_an_authority_that_is_none_is_said(known: bytes):
    refusal = why_refused("127.0.0.1", 9, Credentials(known, GUEST.certificate, GUEST.key))
    assert refusal is not None
    assert not refusal.may_pass
    assert "cannot be used" in refusal.words
