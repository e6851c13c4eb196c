"""Progress of a suite on standard error: what is done, and the time that is left."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from reflexarc.terminal.output import aside


@contextmanager
def show_suite_progress(title: str) -> Iterator[Callable[[float, float], None]]:
    """A bar; what it yields is called with (done, total)."""
    columns = TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn()
    with Progress(
        *columns,
        TimeRemainingColumn(),
        console=aside,
        transient=True,
        speed_estimate_period=600.0,
        disable=not aside.is_terminal,
    ) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
