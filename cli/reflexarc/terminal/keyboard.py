"""Reads single keys at a terminal without waiting for them: the space bar pauses, q quits."""

import os
import select
import sys
import termios
from types import TracebackType
from typing import Any, Self

PAUSE, QUIT = " ", "q"


class Keys:
    """A context manager that reads keys; leaving it restores the terminal, even after an error.

    Without a terminal, or as a background process, it reads nothing: no key can be pressed.
    """

    def __init__(self) -> None:
        self._terminal: int | None = None
        self._before: list[Any] = []
        self._paused = self._quit = self._pressed = False

    def __enter__(self) -> Self:
        self._terminal = _own_terminal()
        if self._terminal is not None:
            self._before = termios.tcgetattr(self._terminal)
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, _key_by_key(self._before))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._terminal is not None:
            termios.tcsetattr(self._terminal, termios.TCSADRAIN, self._before)

    def is_paused(self) -> bool:
        """Whether the space bar was pressed an odd number of times."""
        self._read()
        return self._paused

    def wants_to_quit(self) -> bool:
        """Whether q was pressed."""
        self._read()
        return self._quit

    def was_pressed(self) -> bool:
        """Whether any key was pressed."""
        self._read()
        return self._pressed

    def _read(self) -> None:
        while self._terminal is not None and select.select([self._terminal], [], [], 0.0)[0]:
            pressed = os.read(self._terminal, 1).decode("latin-1")
            if not pressed:  # the terminal has gone away
                return
            self._pressed = True
            self._paused ^= pressed == PAUSE
            self._quit |= pressed == QUIT


def _own_terminal() -> int | None:
    """Standard input, if it is a terminal with this process in the foreground."""
    try:
        number = sys.stdin.fileno()
        return number if os.tcgetpgrp(number) == os.getpgrp() else None
    except (AttributeError, OSError, ValueError):
        return None  # closed, a pipe, a file


def _key_by_key(attributes: list[Any]) -> list[Any]:
    """The same terminal, without lines and without echo; Ctrl-C still is a signal."""
    changed = list(attributes)
    changed[3] &= ~(termios.ICANON | termios.ECHO)
    changed[6] = list(attributes[6])
    changed[6][termios.VMIN], changed[6][termios.VTIME] = 1, 0
    return changed
