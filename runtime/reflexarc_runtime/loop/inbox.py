"""The inbox: everything that arrived since the last tick, oldest first.

A subscriber's callback appends; a tick drains. Its size is bounded, in messages and in bytes: when
it is full, the oldest message is dropped and counted, so that a runtime that was blocked goes on
with recent input. What stops a loop, or lets it go on, is dropped last, and a stop after all
resets: no flood pushes it out.

Its order is the order of arrival, in time as well: no message has an earlier arrival than the one
before it, or than the last drain. So a log that another tool sorts by time replays.

It may ring a bell: at the first message of one topic that arrives from a time on, and at the first
one that stops a loop or lets it go on, whenever that arrives.
"""

import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace

from reflexarc_runtime.loop.bell import Bell, new_bell
from reflexarc_runtime.messages.topics import CONTROLS, RESET, SWAP, Topic
from reflexarc_runtime.messages.wire import Message

DEFAULT_CAPACITY = 1024
DEFAULT_CAPACITY_BYTES = 32 << 20
"""Of payloads; the largest that is believed has 1 MiB."""

_CONTROL_NAMES = frozenset(topic.name for topic in CONTROLS)
_SPARED = (RESET.name, SWAP.name)
"""Dropped only when nothing else is left but stops."""
_NO_MORE = (sys.maxsize, Message("", b"", "", b"", 0))


class Inbox:
    """A bounded queue between the bus's threads and the loop."""

    def __init__(
        self, capacity: int = DEFAULT_CAPACITY, capacity_bytes: int = DEFAULT_CAPACITY_BYTES
    ) -> None:
        self._inputs: deque[Message] = deque()
        self._controls: deque[tuple[int, Message]] = deque()
        """Each with the number of inputs that were put before it."""
        self._put_inputs = 0
        self._capacity = capacity
        self._capacity_bytes = capacity_bytes
        self._bytes = 0
        self._turn = threading.Lock()
        self._arrival: Bell | None = None
        """For `take`; silent unless somebody waits there: a ring costs more than all else here."""
        self._is_awaited = False
        self._overflows = 0
        self._latest_ns = 0
        self._bell: Bell | None = None
        self._rings_for = ""
        self._rings_from_ns = sys.maxsize
        self._rung_ns = sys.maxsize

    @property
    def overflows(self) -> int:
        """Messages lost because the inbox was full."""
        return self._overflows

    @property
    def rung_ns(self) -> int:
        """Arrival of the message that rang the bell, since it was armed."""
        return self._rung_ns

    @property
    def was_rung(self) -> bool:
        """Whether the bell was rung since it was armed."""
        return self._rung_ns != sys.maxsize

    def ring_for(self, topic: Topic, bell: Bell) -> None:
        """Ring a bell, once it is armed, for this topic and for what stops a loop."""
        self._rings_for, self._bell = topic.name, bell

    def arm(self, from_ns: int) -> None:
        """Hush the bell, and ring it at the next arrival from this time on: also if it was before.

        Messages of its topic that arrived sooner never ring it.
        """
        with self._turn:
            assert self._bell is not None, "no bell: ring_for was not called"
            self._rung_ns, self._rings_from_ns = sys.maxsize, from_ns
            self._bell.hush()
            waiting = (message for _, message in self._controls)
            for message in (*waiting, *self._inputs):
                if self._rings_at(message, _name_of(message)):
                    self._bell.ring()
                    return

    def put(self, message: Message) -> None:
        """Add a message; from any thread."""
        name = _name_of(message)
        with self._turn:
            if message.received_ns < self._latest_ns:
                # Another thread was quicker, or a tick took the time while this one waited.
                message = replace(message, received_ns=self._latest_ns)
            self._latest_ns = message.received_ns
            self._bytes += len(message.payload)
            if name in _CONTROL_NAMES:
                self._controls.append((self._put_inputs, message))
            else:
                self._inputs.append(message)
                self._put_inputs += 1
            while self._is_over():
                self._drop_one()
            rings = self._rung_ns == sys.maxsize and self._rings_at(message, name)
        if rings and self._bell is not None:  # whoever wakes finds the inbox free
            self._bell.ring()
        if self._is_awaited and self._arrival is not None:
            self._arrival.ring()

    def drain(self, now_ns: Callable[[], int]) -> tuple[tuple[Message, ...], int]:
        """Take all messages, oldest first, and the time."""
        with self._turn:
            messages = tuple(self._inputs) if not self._controls else tuple(self._in_order())
            self._inputs.clear()
            self._controls.clear()
            self._bytes = 0
            self._latest_ns = now_ns()
            return messages, self._latest_ns

    def take(self, timeout_s: float) -> Message | None:
        """Take the oldest message, waiting for one if need be; None after the timeout."""
        is_rung = True
        while is_rung:  # a ring may come late, for a message that was taken without it
            with self._turn:
                oldest = self._oldest()
                self._is_awaited = oldest is None
                if oldest is not None:
                    return oldest
                arrival = self._arrival = self._arrival or new_bell()
                arrival.hush()
            is_rung = arrival.heard(timeout_s)
        with self._turn:
            self._is_awaited = False
            return self._oldest()

    def _rings_at(self, message: Message, name: str) -> bool:
        """Whether a message is one of those that the bell is rung for; it is noted if so."""
        is_awaited = name == self._rings_for and message.received_ns >= self._rings_from_ns
        if self._bell is None or not (is_awaited or name in _CONTROL_NAMES):
            return False
        self._rung_ns = message.received_ns
        return True

    def _is_over(self) -> bool:
        count = len(self._inputs) + len(self._controls)
        return count > self._capacity or self._bytes > self._capacity_bytes

    def _oldest(self) -> Message | None:
        if self._controls and self._controls[0][0] <= self._put_inputs - len(self._inputs):
            oldest = self._controls.popleft()[1]
        elif self._inputs:
            oldest = self._inputs.popleft()
        else:
            return None
        self._bytes -= len(oldest.payload)
        return oldest

    def _in_order(self) -> Iterator[Message]:
        number, controls = self._put_inputs - len(self._inputs), iter(self._controls)
        place, control = next(controls)
        for message in self._inputs:
            while place <= number:
                yield control
                place, control = next(controls, _NO_MORE)
            yield message
            number += 1
        if place < sys.maxsize:
            yield control
            yield from (message for _, message in controls)

    def _drop_one(self) -> None:
        """Drop the oldest input; where there is none, the oldest reset or swap; a stop last."""
        self._overflows += 1
        if self._inputs:
            self._bytes -= len(self._inputs.popleft().payload)
            return
        spared = (n for n, (_, m) in enumerate(self._controls) if _name_of(m) in _SPARED)
        place = next(spared, 0)
        self._bytes -= len(self._controls[place][1].payload)
        del self._controls[place]


def _name_of(message: Message) -> str:
    """Name of the topic that a message is of, if it is one of ours."""
    return message.key.rpartition("/")[2]
