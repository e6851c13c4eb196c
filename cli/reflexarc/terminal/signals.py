"""Ends a command on the signals that ask for it: by a flag that it looks at, or by an exception.

SIGINT (Ctrl-C), SIGTERM, SIGQUIT (Ctrl and backslash) and SIGHUP (the terminal is gone) all end
alike. A hang-up that is ignored stays so: that is how `nohup` keeps a command alive.
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType, TracebackType
from typing import Any, Self


def ending_signals() -> list[signal.Signals]:
    """The signals that end a command, as this process was started."""
    always = [signal.SIGINT, signal.SIGTERM, signal.SIGQUIT]
    is_ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return always if is_ignored else [*always, signal.SIGHUP]


@contextmanager
def terminated_as_interrupted() -> Iterator[None]:
    """A context in which each of them raises KeyboardInterrupt, as Ctrl-C does: every `finally`
    runs.
    """
    handler = signal.default_int_handler
    before = {number: signal.signal(number, handler) for number in ending_signals()}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


class StopFlag:
    """A context manager that catches all of them; calling it tells whether one came."""

    def __init__(self) -> None:
        self._set = False
        self._before: dict[signal.Signals, Any] = {}

    def __call__(self) -> bool:
        """Whether a signal came."""
        return self._set

    def __enter__(self) -> Self:
        for number in ending_signals():
            self._before[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._set = True
