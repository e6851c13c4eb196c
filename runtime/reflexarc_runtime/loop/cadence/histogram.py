"""A histogram of times with buckets of equal relative width: bounded, and quick to add to.

The buckets are those of an HDR histogram (G. Tene, hdrhistogram.org): 32 of equal width in every
power of two, exact below 64 ns. What is read off it is the middle of a bucket, so it is wrong by at
most 1/64 of itself (1.6 %). The largest time is kept as it is.
"""

from array import array
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.messages.spread import Spread

BITS = 5
WIDTHS = 1 << BITS
"""Buckets in a power of two."""
MOST_BITS = 40
"""Times from 2^40 ns (18 minutes) on share the last bucket."""
BUCKETS = WIDTHS * (MOST_BITS - BITS + 1)
ABSENT = -1
"""Stands for a time that there was not: it is not counted."""

Counts = npt.NDArray[np.int64]


class Histogram:
    """Counts times, in nanoseconds."""

    def __init__(self) -> None:
        self.counts = array("q", bytes(8 * BUCKETS))
        self.max_ns = 0

    def take(self, other: "Histogram") -> None:
        """Count all that another one counted."""
        _view(self)[:] += _view(other)
        self.max_ns = max(self.max_ns, other.max_ns)

    def spread(self) -> Spread:
        """What it says."""
        counts = _view(self)
        total = int(counts.sum())
        if not total:
            return Spread()
        least_bits, octaves = _octaves(counts)
        p50_ns, p99_ns, p999_ns = _percentiles(counts, total, self.max_ns)
        sum_ns = int(counts @ _MIDDLES_NS)
        return Spread(total, p50_ns, p99_ns, p999_ns, self.max_ns, least_bits, octaves, sum_ns)


def add_each(times_ns: Iterable[int], histograms: Iterable[Histogram]) -> None:
    """Add one time to each histogram; what is absent, to none.

    One loop for all of them, at every tick: a call for each would take three times as long.
    """
    for time_ns, histogram in zip(times_ns, histograms, strict=True):
        shift = time_ns.bit_length() - (BITS + 1)
        if time_ns > histogram.max_ns:
            histogram.max_ns = time_ns
        if shift <= 0:
            if time_ns >= 0:
                histogram.counts[time_ns] += 1
        elif time_ns > 0:
            bucket = (shift << BITS) + (time_ns >> shift)
            histogram.counts[bucket if bucket < BUCKETS else BUCKETS - 1] += 1


def _view(histogram: Histogram) -> Counts:
    return np.frombuffer(histogram.counts, np.int64)


def _middle_ns(bucket: int) -> int:
    """The time that stands for all that a bucket counts."""
    if bucket < 2 * WIDTHS:
        return bucket
    shift = (bucket >> BITS) - 1
    return ((bucket - (shift << BITS)) << shift) + (1 << shift >> 1)


_MIDDLES_NS = np.array([_middle_ns(bucket) for bucket in range(BUCKETS)], np.int64)


def _percentiles(counts: Counts, total: int, max_ns: int) -> list[int]:
    """The smallest times that 50, 99 and 99.9 % of all do not exceed."""
    ranks = [-(-total * share // 1000) for share in (500, 990, 999)]
    buckets = np.searchsorted(np.cumsum(counts), ranks).tolist()
    return [min(_middle_ns(bucket), max_ns) for bucket in buckets]


def _octaves(counts: Counts) -> tuple[int, tuple[int, ...]]:
    """The least number of bits that any time has, and the counts from that number to the last."""
    below = [0, *(1 << bits for bits in range(BITS + 1))]  # 0, then 1, 2 to 3, 4 to 7, …
    by_bits = np.add.reduceat(counts[: 2 * WIDTHS], below).tolist()
    by_bits += counts[2 * WIDTHS :].reshape(-1, WIDTHS).sum(axis=1).tolist()
    filled = [bits for bits, count in enumerate(by_bits) if count]
    return filled[0], tuple(by_bits[filled[0] : filled[-1] + 1])
