"""The inbox: everything that arrived since the last tick, oldest first.

A subscriber's callback appends; a tick drains. Its size is bounded, in messages and in bytes: when
it is full, the oldest message is dropped and counted, so that a runtime that was blocked goes on
with recent input. What stops a loop, or lets it go on, is dropped last, and a stop after all
resets: no flood pushes it out.

Its order is the order of arrival, in time as well: no message has an earlier arrival than the one
before it, or than the last drain. So a log that another tool sorts by time replays.
"""

import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace

from reflexarc_runtime.messages.topics import CONTROLS, RESET, SWAP, topic_of
from reflexarc_runtime.messages.wire import Message

DEFAULT_CAPACITY = 1024
DEFAULT_CAPACITY_BYTES = 32 << 20
"""Of payloads; the largest that is believed has 1 MiB."""

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
        self._arrival = threading.Condition()
        self._overflows = 0
        self._latest_ns = 0

    @property
    def overflows(self) -> int:
        """Messages lost because the inbox was full."""
        return self._overflows

    def put(self, message: Message) -> None:
        """Add a message; from any thread."""
        with self._arrival:
            if message.received_ns < self._latest_ns:
                # Another thread was quicker, or a tick took the time while this one waited.
                message = replace(message, received_ns=self._latest_ns)
            self._latest_ns = message.received_ns
            self._bytes += len(message.payload)
            if topic_of(message.key) in CONTROLS:
                self._controls.append((self._put_inputs, message))
            else:
                self._inputs.append(message)
                self._put_inputs += 1
            while self._is_over():
                self._drop_one()
            self._arrival.notify()

    def drain(self, now_ns: Callable[[], int]) -> tuple[tuple[Message, ...], int]:
        """Take all messages, oldest first, and the time."""
        with self._arrival:
            messages = tuple(self._inputs) if not self._controls else tuple(self._in_order())
            self._inputs.clear()
            self._controls.clear()
            self._bytes = 0
            self._latest_ns = now_ns()
            return messages, self._latest_ns

    def take(self, timeout_s: float) -> Message | None:
        """Take the oldest message, waiting for one if need be; None after the timeout."""
        with self._arrival:
            if not (self._inputs or self._controls):
                self._arrival.wait(timeout_s)
            return self._oldest()

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
        spared = (n for n, (_, m) in enumerate(self._controls) if topic_of(m.key) in (RESET, SWAP))
        place = next(spared, 0)
        self._bytes -= len(self._controls[place][1].payload)
        del self._controls[place]
