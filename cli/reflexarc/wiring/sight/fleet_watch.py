"""Listens to every robot on a bus: statuses, leases, and who announces itself."""

import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from reflexarc_runtime.fleet.fleet import Fleet
from reflexarc_runtime.fleet.views import FleetView
from reflexarc_runtime.messages.topics import LEASE, STATUS, alive_key
from reflexarc_runtime.messages.wire import Message

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

_SETTLED_NS = 1_200_000_000
"""Whoever is there says something every second."""
_MOST_SETTLING_NS = 6_000_000_000
_EVERY = "*"
_LOOK_S = 0.05


class FleetWatch:
    """What is heard of all robots, from now on.

    Args:
        bus: an open session.
        now_ns: the clock by which it stamps what comes.
    """

    def __init__(self, bus: "Bus", now_ns: Callable[[], int] = time.monotonic_ns) -> None:
        self._now_ns = now_ns
        self._fleet = Fleet()
        self._turn = threading.Lock()
        self._first_ns: int | None = None
        self._newest_ns: int | None = None
        bus.subscribe_to_key(STATUS.key(_EVERY), self._hear)
        bus.subscribe_to_key(LEASE.key(_EVERY), self._hear)
        bus.watch_tokens(alive_key(_EVERY, _EVERY), self._announced)

    def view(self) -> FleetView:
        """The fleet now; from any thread."""
        with self._turn:
            return self._fleet.view(self._now_ns())

    def await_all(self, patience_s: float, stop: Callable[[], bool]) -> None:
        """Wait until every node that is there has said something, or nobody has in time.

        Args:
            patience_s: how long the first word is waited for.
            stop: ends the waiting.
        """
        end_ns = self._now_ns() + round(patience_s * 1e9)
        while not stop() and self._now_ns() < self._until(end_ns):
            time.sleep(_LOOK_S)

    def _until(self, end_ns: int) -> int:
        """How long it is worth waiting: until every other node would have spoken as well.

        Who announces itself has a little longer, on a busy machine. New names may come without an
        end; a listing does not wait for that.
        """
        with self._turn:
            first_ns, newest_ns = self._first_ns, self._newest_ns
        if first_ns is None or newest_ns is None:
            return end_ns
        most_ns = first_ns + _MOST_SETTLING_NS
        if any(robot.owes_a_word for robot in self.view().robots):
            return most_ns
        return min(newest_ns + _SETTLED_NS, most_ns)

    def _hear(self, message: Message) -> None:
        with self._turn:
            if self._fleet.hear(message):
                self._saw_another(message.received_ns)

    def _announced(self, key: str, is_there: bool) -> None:
        now_ns = self._now_ns()
        with self._turn:
            if self._fleet.announced(key, now_ns, is_there=is_there):
                self._saw_another(now_ns)

    def _saw_another(self, now_ns: int) -> None:
        self._first_ns = now_ns if self._first_ns is None else self._first_ns
        self._newest_ns = now_ns
