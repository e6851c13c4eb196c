"""The time of a log: whoever sleeps on it lets the messages of that time arrive, at once."""

from collections.abc import Callable, Iterator

from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.messages.wire import Message


class LogClock(ManualClock):
    """A clock that is moved by sleeping, and hands out the messages that arrive meanwhile.

    Args:
        messages: by arrival; the first one's is where the clock begins.
        deliver: takes each message when its time has come.
        linger_ns: how long the log lasts behind its last message.
    """

    def __init__(
        self,
        messages: Iterator[Message],
        deliver: Callable[[Message], None],
        linger_ns: int,
    ) -> None:
        self._messages, self._deliver = messages, deliver
        self._linger_ns = linger_ns
        self._next = next(messages, None)
        self._last_ns = 0 if self._next is None else self._next.received_ns
        super().__init__(self._last_ns)

    @property
    def is_over(self) -> bool:
        """Whether all messages have arrived, and a while is over."""
        return self._next is None and self.time_ns > self._last_ns + self._linger_ns

    def sleep_until_ns(self, deadline_ns: int) -> None:
        """See `Clock.sleep_until_ns`."""
        super().sleep_until_ns(deadline_ns)
        while self._next is not None and self._next.received_ns <= self.time_ns:
            self._last_ns = max(self._last_ns, self._next.received_ns)
            self._deliver(self._next)
            self._next = next(self._messages, None)
