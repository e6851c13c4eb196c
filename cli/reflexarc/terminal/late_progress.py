"""Progress of what is usually done at once: a bar that comes after two seconds."""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager

from reflexarc.terminal.output import progress_bar

LATE_S = 2.0


@contextmanager
def late_progress(title: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A bar on standard error; what it yields is called with (done, total)."""
    begun_s, bars = time.monotonic(), list[Callable[[int, int], None]]()
    with ExitStack() as stack:

        def tell(done: int, of: int) -> None:
            if not bars and time.monotonic() - begun_s >= LATE_S:
                bars.append(stack.enter_context(progress_bar(title, total)))
            for bar in bars:
                bar(done, of)

        yield tell
