"""Progress of a training run and of a study, on standard error."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from reflexarc.terminal.compilation import saying
from reflexarc.terminal.output import aside
from reflexarc_sim_bridge.native.compile_progress import watched_by
from reflexarc_trainer.run.train import ProgressCallback, TrainingProgress
from reflexarc_trainer.study.study import StudyProgress


@contextmanager
def show_progress() -> Iterator[ProgressCallback]:
    """A bar with rate, ε, error and contacts on validation worlds, on standard error."""
    columns = (
        TextColumn("learning"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[said]}", markup=False),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=aside, transient=True) as bar:
        task = bar.add_task("learning", said="beginning", total=None)

        def tell(progress: TrainingProgress) -> None:
            bar.update(task, completed=progress.step, total=progress.steps, said=said_of(progress))

        with watched_by(saying(lambda words: bar.update(task, said=words))):
            yield tell


@contextmanager
def show_study_progress() -> Iterator[Callable[[StudyProgress], None]]:
    """A bar with the runs that are done and the time that is left, on standard error."""
    columns = (
        TextColumn("studying"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("runs  {task.fields[said]}", markup=False),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=aside, transient=True, speed_estimate_period=600.0) as bar:
        task = bar.add_task("studying", said="", total=None)

        def tell(progress: StudyProgress) -> None:
            said = _said_of_study(progress)
            bar.update(task, completed=progress.done, total=progress.units, said=said)

        yield tell


def said_of(progress: TrainingProgress) -> str:
    """Rate, ε, error, and contacts on validation worlds once there are any."""
    rate = f"{progress.steps_per_s / 1e3:.0f} k steps/s"
    said = f"{rate}  ε {progress.epsilon:.2f}  error {progress.mean_abs_error:.3f}"
    if progress.last is None:
        return said
    return f"{said}  contacts per 100 m {progress.last.validation_contacts_per_100m:.1f}"


def _said_of_study(progress: StudyProgress) -> str:
    last = progress.last
    if last is None:
        return "beginning"
    if last.contacts_per_100m is None:
        return "last: diverged"
    return f"last: {last.contacts_per_100m:.1f} contacts per 100 m"
