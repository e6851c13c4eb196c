"""Sends faulty retinas when they are due, from a thread of its own.

So the body's loop keeps its rate, and a message that is to be late by 7 ms is sent 7 ms late, not
at the next step.
"""

import heapq
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

from reflexarc_sim_bridge.body.faults.faulty_stream import FaultyStream, Sending
from reflexarc_sim_bridge.body.faults.script import FaultScript


class DelayedSender:
    """Publishes retinas with faults. A context manager: what is not due at its end is dropped.

    Args:
        script: what goes wrong.
        send: puts one message onto the bus; called on this object's thread.
        now_ns: the body's clock.
    """

    def __init__(
        self, script: FaultScript, send: Callable[[Sending], None], now_ns: Callable[[], int]
    ) -> None:
        self._stream = FaultyStream(script)
        self._send = send
        self._now_ns = now_ns
        self._waiting: list[tuple[int, int, Sending]] = []
        self._taken = 0
        self._closed = False
        self._change = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="delayed-sender", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._change:
            self._closed = True
            self._change.notify()
        self._thread.join()

    @property
    def sender(self) -> bytes:
        """The identifier that the body's own retinas carry now."""
        return self._stream.sender

    def put(self, payload: bytes, time_ns: int) -> None:
        """Take a retina that was seen at `time_ns`; never blocks."""
        with self._change:
            for sending in self._stream.say(payload, time_ns):
                # the count keeps the order of messages that are due at once
                heapq.heappush(self._waiting, (sending.due_ns, self._taken, sending))
                self._taken += 1
            self._change.notify()

    def _run(self) -> None:
        while (sending := self._next()) is not None:
            self._send(sending)

    def _next(self) -> Sending | None:
        """Wait for the next message that is due; None at the end."""
        with self._change:
            while not self._closed:
                wait_s = self._wait_s()
                if wait_s is not None and wait_s <= 0.0:
                    return heapq.heappop(self._waiting)[2]
                self._change.wait(wait_s)
            return None

    def _wait_s(self) -> float | None:
        return (self._waiting[0][0] - self._now_ns()) * 1e-9 if self._waiting else None
