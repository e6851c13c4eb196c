"""From which tick to which a log is cut: numbers of ticks, or seconds since the first one."""

from dataclasses import dataclass

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.reading.tick_word import tick_word
from reflexarc_runtime.errors import LogError, UsageError


@dataclass(frozen=True)
class TickSpan:
    """Ticks from `first` on, up to and without `end`."""

    first: int
    end: int


def span_of(log: Log, since: str = "", until: str = "") -> TickSpan:
    """The ticks that two words mean.

    Args:
        log: the log.
        since: a tick's number ("120"), or seconds since the log's first tick ("2.4s"); empty: from
            the first tick on.
        until: the same for the tick before which it ends; empty: to the last tick.

    Raises:
        UsageError: a word that is neither, or a span without a tick.
        LogError: the log has no ticks.
    """
    times_ns = {tick.decision.index: tick.decision.now_ns for tick in log.ticks()}
    if not times_ns:
        raise LogError(f"{log.path}: expected ticks, found none; nothing to cut")
    begins, ends = min(times_ns), max(times_ns) + 1
    first = _tick("--from", since, times_ns) if since else begins
    end = _tick("--to", until, times_ns) if until else ends
    span = TickSpan(max(first, begins), min(end, ends))
    if span.first >= span.end:
        raise UsageError(
            f"--from {since or begins} --to {until or ends}: expected at least one tick between "
            f"them; the log has ticks {begins} to {ends - 1}"
        )
    return span


def _tick(flag: str, word: str, times_ns: dict[int, int]) -> int:
    """The number of a tick; of a time, that of the first tick at or after it."""
    place = tick_word(flag, word)
    if place.index is not None:
        return place.index
    begin_ns = min(times_ns.values())
    later = (i for i, now_ns in times_ns.items() if place.is_reached_by(i, now_ns - begin_ns))
    return min(later, default=max(times_ns) + 1)
