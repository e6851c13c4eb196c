"""Validation points as TensorBoard event files, if that package is installed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.run.history import Row

FOLDER = "tensorboard"


@contextmanager
def event_files(out: Path) -> Iterator[Callable[[Row], None]]:
    """A context whose function writes a validation point: one scalar per column of `metrics.csv`.

    A resumed run adds a file. Points of an earlier run in this folder are hidden from the new run's
    first step on.

    Args:
        out: the run's folder; the files are written into a subfolder of it.

    Raises:
        UsageError: TensorBoard is not installed.
    """
    try:
        from torch.utils.tensorboard import SummaryWriter
    except ImportError:
        raise UsageError(
            "tensorboard: not installed here; install the extra: "
            "pip install 'reflexarc[tensorboard]'"
        ) from None
    writers: list[SummaryWriter] = []

    def write(row: Row) -> None:
        if not writers:
            writers.append(SummaryWriter(str(out / FOLDER), purge_step=row.step))
        for name, value in row._asdict().items():
            if name != "step":
                writers[0].add_scalar(name, value, row.step)
        writers[0].flush()

    try:
        yield write
    finally:
        for writer in writers:
            writer.close()
