"""A line on the terminal while the simulated world or a learner is compiled to machine code.

That happens once for each version, and takes many seconds.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from threading import Event, Thread
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside

if TYPE_CHECKING:
    from reflexarc_sim_bridge.native.compile_progress import Compilation, Watcher

_PERIOD_S = 0.5
_CLEAR_LINE = "\r\x1b[2K"


@contextmanager
def show_compilation() -> Iterator[None]:
    """Within the context, say on a terminal what is being compiled; elsewhere nothing is said."""
    if not aside.is_terminal:
        yield
        return
    from reflexarc_sim_bridge.native.compile_progress import watched_by

    with watched_by(saying(_write_line)):
        yield


def saying(show: Callable[[str], object]) -> "Watcher":
    """A watcher that shows, twice a second, what is compiled and how long it still takes.

    Args:
        show: given a line, and an empty one at the end.
    """
    return partial(_shown, show)


def words_for(begun: "Compilation") -> str:
    """What is compiled, and how long it still takes, in words."""
    return f"compiling {begun.current} (once for this version): {begun.left_s:.0f} s left"


def _shown(show: Callable[[str], object], begun: "Compilation") -> AbstractContextManager[None]:
    return _repeated(lambda: show(words_for(begun)), lambda: show(""))


@contextmanager
def _repeated(say: Callable[[], object], end: Callable[[], object]) -> Iterator[None]:
    ended = Event()

    def go_on() -> None:
        while not ended.wait(_PERIOD_S):
            say()

    thread = Thread(target=go_on, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        end()


def _write_line(words: str) -> None:
    aside.file.write(f"{_CLEAR_LINE}{words}")
    aside.file.flush()
