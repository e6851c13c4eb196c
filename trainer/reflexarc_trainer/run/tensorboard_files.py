"""A run's validation points as TensorBoard event files, where that package is installed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.run.history import Row

FOLDER = "tensorboard"


@contextmanager
def event_files(out: Path) -> Iterator[Callable[[Row], None]]:
    """Within it, what is yielded writes a point; one scalar a column of `metrics.csv`.

    A resumed run adds a file; points of an earlier run in the same folder that lie beyond the new
    one's are withdrawn.

    Args:
        out: the run's folder; the files go into a folder of their own in it.

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
