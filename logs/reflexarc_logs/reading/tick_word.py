"""A place in a log as people write it: a tick's number, or seconds since the log's first tick."""

from dataclasses import dataclass

from reflexarc_runtime.errors import UsageError


@dataclass(frozen=True)
class TickWord:
    """A place in a log: one of the two is there."""

    index: int | None
    """A tick's number."""
    after_ns: int | None
    """Time since the log's first tick."""

    def is_reached_by(self, index: int, after_ns: int) -> bool:
        """Whether a tick is at this place or behind it.

        Args:
            index: the tick's number.
            after_ns: its time since the log's first tick.
        """
        if self.index is not None:
            return index >= self.index
        return self.after_ns is not None and after_ns >= self.after_ns


def tick_word(flag: str, word: str) -> TickWord:
    """The place that a word means: "120" is a tick's number, "2.4s" a time.

    Raises:
        UsageError: it is neither; the message begins with `flag`.
    """
    try:
        if word.startswith("-"):
            raise ValueError("a time or number before the first")
        if word.endswith("s"):
            return TickWord(None, round(float(word[:-1]) * 1e9))
        return TickWord(int(word), None)
    except (ValueError, OverflowError):
        raise UsageError(
            f"{flag}: expected a tick's number or seconds, as 120 or 2.4s, got {word[:20]!r}"
        ) from None
