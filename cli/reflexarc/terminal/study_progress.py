"""A study as a person sees it go by."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeRemainingColumn
from rich.progress import Progress as Bar

from reflexarc.terminal.output import aside
from reflexarc_trainer.study.study import Progress


@contextmanager
def show_study_progress() -> Iterator[Callable[[Progress], None]]:
    """A bar with the runs that are done and the time that is left, on standard error."""
    columns = (
        TextColumn("studying"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("runs  {task.fields[said]}"),
        TimeRemainingColumn(),
    )
    with Bar(*columns, console=aside, transient=True, speed_estimate_period=600.0) as bar:
        task = bar.add_task("studying", said="", total=None)

        def tell(progress: Progress) -> None:
            said = _said(progress)
            bar.update(task, completed=progress.done, total=progress.units, said=said)

        yield tell


def _said(progress: Progress) -> str:
    last = progress.last
    if last is None:
        return "beginning"
    if last.contacts_per_100m is None:
        return "last: diverged"
    return f"last: {last.contacts_per_100m:.1f} contacts per 100 m"
