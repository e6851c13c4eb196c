import os
import socket
from pathlib import Path

import pytest

from reflexarc_runtime.service.manager import NoManager, ServiceManager, manager_of

MS = 1_000_000


def words() -> str:
    return "OK"


class Heard:
    """Keeps the datagrams, each as its lines."""

    def __init__(self) -> None:
        self.lines: list[list[str]] = []

    def __call__(self, datagram: bytes) -> None:
        self.lines.append(datagram.decode().split("\n"))


def test_the_first_tick_says_that_the_service_is_ready():
    heard = Heard()
    ServiceManager(heard, 2000 * MS).ticked(5, words)
    assert heard.lines == [["READY=1", "WATCHDOG=1", "STATUS=OK"]]


def test_a_word_of_readiness_that_was_lost_is_said_again():
    """The socket of a busy manager is full: EAGAIN. Unheard, it would end a robot that drives."""
    heard, is_full = Heard(), True

    def send(datagram: bytes) -> None:
        if is_full:
            raise BlockingIOError
        heard(datagram)

    manager = ServiceManager(send, 2000 * MS)
    for tick in range(10):
        manager.ticked(tick * 20 * MS, words)
    is_full = False
    for tick in range(10, 20):
        manager.ticked(tick * 20 * MS, words)
    assert [line for line in heard.lines if "READY=1" in line] == heard.lines
    assert len(heard.lines) == 1


def test_a_manager_that_is_gone_costs_little():
    """At 1 kHz it is not tried at every tick."""
    tried = []

    def gone(datagram: bytes) -> None:
        tried.append(datagram)
        raise FileNotFoundError

    manager = ServiceManager(gone)
    for tick in range(1000):
        manager.ticked(tick * MS, words)
    assert 10 <= len(tried) <= 25


def test_who_waits_asks_for_time_and_says_for_whom():
    heard = Heard()
    manager = ServiceManager(heard, 2000 * MS)
    manager.waiting("no router\nREADY=1")
    ((extends, status),) = heard.lines
    assert extends.startswith("EXTEND_TIMEOUT_USEC=")
    assert int(extends.partition("=")[2]) >= 30_000_000
    assert status == "STATUS=waiting: no router READY=1"


def test_ticks_feed_the_watchdog_four_times_within_its_patience_and_no_more():
    heard = Heard()
    manager = ServiceManager(heard, 400 * MS)
    for tick in range(40):  # 800 ms at 50 Hz
        manager.ticked(tick * 20 * MS, words)
    assert [line for line in heard.lines if "WATCHDOG=1" in line] == heard.lines
    assert len(heard.lines) == 8


def test_without_ticks_nobody_feeds_it():
    heard = Heard()
    manager = ServiceManager(heard, 400 * MS)
    manager.ticked(0, words)
    assert len(heard.lines) == 1  # there is no thread beside the loop


def test_once_a_second_it_says_how_the_loop_fares():
    heard = Heard()
    manager = ServiceManager(heard)
    for tick in range(151):
        manager.ticked(tick * 20 * MS, words)
    assert [any(part.startswith("STATUS=") for part in line) for line in heard.lines] == [True] * 4


def test_a_manager_that_is_gone_stops_no_loop():
    def gone(datagram: bytes) -> None:
        raise ConnectionRefusedError

    manager = ServiceManager(gone)
    manager.waiting("a router")
    manager.ticked(0, words)
    manager.ending()


def test_words_cannot_say_more_than_a_status():
    """A reason that came from outside must not be read as another line of the protocol."""
    heard = Heard()
    ServiceManager(heard).ticked(0, lambda: "bad\nMAINPID=1")
    assert heard.lines[0][-1] == "STATUS=bad MAINPID=1"


@pytest.mark.parametrize("place", ["", "relative", "vsock:1:2"])
def test_without_a_socket_nothing_is_said(place):
    assert isinstance(manager_of({"NOTIFY_SOCKET": place} if place else {}), NoManager)


def test_it_speaks_on_a_real_socket_and_children_do_not(tmp_path: Path):
    place = str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as ours:
        ours.bind(place)
        ours.settimeout(5.0)
        given = {
            "NOTIFY_SOCKET": place,
            "WATCHDOG_USEC": "2000000",
            "WATCHDOG_PID": str(os.getpid()),
        }
        manager = manager_of(given)
        assert given == {}
        manager.ticked(0, words)
        assert ours.recv(4096) == b"READY=1\nWATCHDOG=1\nSTATUS=OK"
        manager.ticked(500 * MS, words)
        assert ours.recv(4096) == b"WATCHDOG=1"
        manager.ending()
        assert ours.recv(4096).startswith(b"STOPPING=1\n")


def test_an_abstract_socket_is_reached_as_well():
    name = f"reflexarc-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as ours:
        ours.bind(f"\0{name}")
        ours.settimeout(5.0)
        manager_of({"NOTIFY_SOCKET": f"@{name}"}).ticked(0, words)
        assert ours.recv(4096).startswith(b"READY=1")


def test_the_watchdog_of_another_process_is_not_fed(tmp_path: Path):
    place = str(tmp_path / "notify")
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as ours:
        ours.bind(place)
        ours.settimeout(0.0)
        given = {"NOTIFY_SOCKET": place, "WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "1"}
        manager = manager_of(given)
        manager.ticked(0, words)
        ours.recv(4096)
        manager.ticked(900 * MS, words)
        with pytest.raises(BlockingIOError):
            ours.recv(4096)
