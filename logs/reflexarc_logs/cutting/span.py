"""From which tick to which a log is cut: numbers of ticks, or seconds since the first one."""

from dataclasses import dataclass

from reflexarc_logs.reading.reader import Log
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
    try:
        if word.startswith("-"):
            raise ValueError("a time or number before the first")
        if not word.endswith("s"):
            return int(word)
        wanted_ns = min(times_ns.values()) + round(float(word[:-1]) * 1e9)
    except (ValueError, OverflowError):
        raise UsageError(
            f"{flag}: expected a tick's number or seconds, as 120 or 2.4s, got {word[:20]!r}"
        ) from None
    later = (index for index, now_ns in times_ns.items() if now_ns >= wanted_ns)
    return min(later, default=max(times_ns) + 1)
