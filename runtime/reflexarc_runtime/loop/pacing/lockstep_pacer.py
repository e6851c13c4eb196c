"""One tick for each sensor message, at its source time.

It reads no clock and does not sleep: the same inputs give the same ticks on any machine under any
load.
"""

from collections.abc import Callable
from dataclasses import replace

from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing.pacer import Wakeup
from reflexarc_runtime.messages.topics import CONTROLS, topic_of
from reflexarc_runtime.messages.wire import Message, at_source_time

LOCKSTEP_PATIENCE_S = 0.05
"""Interval at which a waiting lockstep loop checks whether it should end."""


class LockstepPacer:
    """One tick for each sensor message, at its source time.

    A stop or a reset makes no tick of its own, and no time: it comes with the next sensor message,
    so that the command of message n stays command n.
    """

    def __init__(self, inbox: Inbox) -> None:
        self._inbox = inbox
        self._controls: list[Message] = []
        self._slot = 0
        self._time_ns = 0

    def wait(self, should_stop: Callable[[], bool]) -> Wakeup | None:
        """See `Pacer.wait`."""
        while not should_stop():
            message = self._inbox.take(LOCKSTEP_PATIENCE_S)
            if message is None:
                continue
            if topic_of(message.key) in CONTROLS:
                self._controls.append(replace(message, received_ns=self._time_ns))
                continue
            arrived = at_source_time(message, self._time_ns)
            self._time_ns = arrived.received_ns
            controls, self._controls = self._controls, []
            return self._wake((*controls, arrived))
        return None

    def farewell(self) -> Wakeup:
        """See `Pacer.farewell`."""
        return self._wake(())

    def now_ns(self) -> int:
        """See `Pacer.now_ns`."""
        return self._time_ns

    def _wake(self, messages: tuple[Message, ...]) -> Wakeup:
        self._slot += 1
        time_ns = self._time_ns
        return Wakeup(self._slot, time_ns, time_ns, time_ns, messages, 0)
