"""What the tracks of a body and of a brain say. Times in nanoseconds, of one monotonic clock."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Rows: TypeAlias = npt.NDArray[np.int64]
PATIENCE_NS = 100_000_000
"""A body stands that was not told to drive for so long."""


def written(rows: Rows) -> Rows:
    """The rows of a track that were written."""
    return rows[rows[:, 0] > 0]


def between(rows: Rows, begin_ns: int, end_ns: int) -> Rows:
    """The rows of a span of time."""
    return rows[(rows[:, 0] >= begin_ns) & (rows[:, 0] < end_ns)]


def latencies_ns(commands: Rows, begin_ns: int, end_ns: int) -> Rows:
    """From a retina's sending in a span of time to the first command that it led to."""
    named = commands[(commands[:, 1] >= begin_ns) & (commands[:, 1] < end_ns)]
    _, first = np.unique(named[:, 1], return_index=True)
    waits: Rows = named[first, 0] - named[first, 1]
    return waits


def unsteadiness_ns(rows: Rows, period_ns: int) -> Rows:
    """By how much the time from each row to the next is longer or shorter than a period."""
    gaps: Rows = np.abs(np.diff(rows[:, 0]) - period_ns)
    return gaps


def standstill_ns(commands: Rows, begin_ns: int, until_ns: int) -> int | None:
    """From a moment to standstill for good; None if the body drives until the end.

    It stands from the first command that does not drive, or `PATIENCE_NS` after the last that does.

    Args:
        commands: time of arrival, time of the retina's sending, whether it drives.
        begin_ns: when the sensor ended.
        until_ns: how long the body was watched.
    """
    seen = commands[commands[:, 0] < until_ns]
    driving = np.flatnonzero(seen[:, 2])
    if not len(driving):
        return 0
    last = int(driving[-1])
    stands_ns = int(seen[last, 0]) + PATIENCE_NS
    if last + 1 < len(seen):
        stands_ns = min(stands_ns, int(seen[last + 1, 0]))
    return max(0, stands_ns - begin_ns) if stands_ns < until_ns else None
