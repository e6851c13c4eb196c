"""Tells the service manager how the loop fares: ready, alive at each tick, ending.

The protocol is that of sd_notify(3): a line of text in a datagram to the Unix socket that the
environment names. It needs no library: a robot without systemd has no socket, and nothing is sent.

Whoever feeds the manager's watchdog is the loop, at the end of a tick, and no thread beside it: a
loop that hangs is not fed, and the manager ends the process and starts it again.
"""

import contextlib
import faulthandler
import os
import socket
from collections.abc import Callable, MutableMapping
from typing import Protocol

_SOCKET, _WATCHDOG, _PROCESS = "NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"
_FEEDINGS = 4
"""Within the manager's patience: one that is lost, or late, does no harm."""
_SAID_EVERY_NS = 1_000_000_000
_READY_AGAIN_NS = 50_000_000
"""A word that was lost is said again: who is not heard to be ready is ended, however it drives."""
_WAITS_S = 60
"""What a start that waits for somebody asks for, again and again: longer than one try takes."""


class Manager(Protocol):
    """What a loop tells whoever started it as a service."""

    def ticked(self, now_ns: int, words: Callable[[], str]) -> None:
        """A tick has ended; the first one says that the service is ready.

        Args:
            now_ns: the loop's monotonic clock.
            words: how it fares; asked once a second.
        """
        ...

    def waiting(self, words: str) -> None:
        """It cannot begin yet, for want of somebody, and is well: said again and again.

        Args:
            words: what it waits for.
        """
        ...

    def ending(self) -> None:
        """The loop was asked to end."""
        ...


class NoManager:
    """Nobody asked."""

    def ticked(self, now_ns: int, words: Callable[[], str]) -> None:
        """See `Manager.ticked`."""

    def waiting(self, words: str) -> None:
        """See `Manager.waiting`."""

    def ending(self) -> None:
        """See `Manager.ending`."""


class ServiceManager:
    """Speaks to the manager on its socket; whatever fails is not said, and the loop goes on.

    Args:
        send: takes a datagram, or raises OSError.
        watchdog_ns: the manager's patience with a silent service; None: it has no watchdog.
    """

    def __init__(self, send: Callable[[bytes], None], watchdog_ns: int | None = None) -> None:
        self._send = send
        self._feed_every_ns = None if watchdog_ns is None else watchdog_ns // _FEEDINGS
        self._fed_ns = self._said_ns = 0
        self._is_known_ready = False
        self._ready_again_ns: int | None = None

    def ticked(self, now_ns: int, words: Callable[[], str]) -> None:
        """See `Manager.ticked`."""
        if not self._is_known_ready:
            if self._ready_again_ns is None or now_ns >= self._ready_again_ns:
                self._ready_again_ns = now_ns + _READY_AGAIN_NS
                self._fed_ns = self._said_ns = now_ns
                self._is_known_ready = self._tell("READY=1", "WATCHDOG=1", f"STATUS={words()}")
        elif now_ns - self._said_ns >= _SAID_EVERY_NS:
            self._fed_ns = self._said_ns = now_ns
            self._tell("WATCHDOG=1", f"STATUS={words()}")
        elif self._feed_every_ns is not None and now_ns - self._fed_ns >= self._feed_every_ns:
            self._fed_ns = now_ns
            self._tell("WATCHDOG=1")

    def waiting(self, words: str) -> None:
        """See `Manager.waiting`."""
        self._tell(f"EXTEND_TIMEOUT_USEC={_WAITS_S * 1_000_000}", f"STATUS=waiting: {words}")

    def ending(self) -> None:
        """See `Manager.ending`."""
        self._tell("STOPPING=1", "STATUS=ending: the log is being finished")

    def _tell(self, *lines: str) -> bool:
        """Say it; whether it was taken."""
        words = "\n".join(line.replace("\n", " ") for line in lines)
        try:
            self._send(words.encode())
        except OSError:  # a manager that is gone, or busy, stops no robot
            return False
        return True


def manager_of(environment: MutableMapping[str, str] | None = None) -> Manager:
    """The manager that started this process, if one did and wants to be told.

    What names it is taken out of the environment: processes that this one starts are no service.
    """
    given = os.environ if environment is None else environment
    place = given.pop(_SOCKET, "")
    patience_us, process = given.pop(_WATCHDOG, ""), given.pop(_PROCESS, "")
    if not place.startswith(("/", "@")):
        return NoManager()
    is_meant = process in ("", str(os.getpid()))
    watched = is_meant and patience_us.isdecimal() and int(patience_us) > 0
    return ServiceManager(_sender(place), int(patience_us) * 1000 if watched else None)


def say_where_it_dies(manager: Manager) -> None:
    """Have a service that its manager ends (SIGABRT), or that breaks, write where its loop was.

    Of one thread alone: others may run meanwhile, and their frames must not be looked at then.
    """
    if not isinstance(manager, NoManager):
        with contextlib.suppress(OSError, ValueError, AttributeError, RuntimeError):  # no stderr
            faulthandler.enable(all_threads=False)


def _sender(place: str) -> Callable[[bytes], None]:
    """Sends datagrams to a Unix socket without waiting; `@` begins an abstract name."""
    address = "\0" + place[1:] if place.startswith("@") else place

    def send(datagram: bytes) -> None:
        # A few a second: a socket of its own each time is never left open, nor found closed.
        with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as out:
            out.setblocking(False)
            out.sendto(datagram, address)

    return send
