"""The inbox: everything that arrived since the last tick, oldest first.

A subscriber's callback appends; a tick drains. Its size is bounded, in messages and in bytes: when
it is full, the oldest message is dropped and counted, so that a runtime that was blocked goes on
with recent input. What stops a loop, or lets it go on, is dropped last: no flood of inputs pushes a
stop out.

Its order is the order of arrival, in time as well: no message has an earlier arrival than the one
before it, or than the last drain. So a log that another tool sorts by time replays.
"""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import replace

from reflexarc_runtime.messages.topics import CONTROLS, topic_of
from reflexarc_runtime.messages.wire import Message

DEFAULT_CAPACITY = 1024
DEFAULT_CAPACITY_BYTES = 32 << 20
"""Of payloads; the largest that is believed has 1 MiB."""


class Inbox:
    """A bounded queue between the bus's threads and the loop."""

    def __init__(
        self, capacity: int = DEFAULT_CAPACITY, capacity_bytes: int = DEFAULT_CAPACITY_BYTES
    ) -> None:
        self._messages: deque[Message] = deque()
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
            self._messages.append(message)
            while self._is_over():
                self._drop_one()
            self._arrival.notify()

    def drain(self, now_ns: Callable[[], int]) -> tuple[tuple[Message, ...], int]:
        """Take all messages, oldest first, and the time."""
        with self._arrival:
            messages = tuple(self._messages)
            self._messages.clear()
            self._bytes = 0
            self._latest_ns = now_ns()
            return messages, self._latest_ns

    def take(self, timeout_s: float) -> Message | None:
        """Take the oldest message, waiting for one if need be; None after the timeout."""
        with self._arrival:
            if not self._messages:
                self._arrival.wait(timeout_s)
            return self._pop(0) if self._messages else None

    def _is_over(self) -> bool:
        return len(self._messages) > self._capacity or self._bytes > self._capacity_bytes

    def _drop_one(self) -> None:
        """Drop the oldest message that is no control; where there is none, the oldest control."""
        inputs = (n for n, m in enumerate(self._messages) if topic_of(m.key) not in CONTROLS)
        self._pop(next(inputs, 0))
        self._overflows += 1

    def _pop(self, place: int) -> Message:
        message = self._messages[place]
        del self._messages[place]
        self._bytes -= len(message.payload)
        return message
