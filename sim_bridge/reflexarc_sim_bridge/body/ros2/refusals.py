"""What a robot said that cannot be used: counted by reason, and each reason said once."""

import logging
import re
from collections import Counter

MOST_REASONS = 16
"""So many different reasons are counted apart."""

AGAIN_NS = 60_000_000_000
"""A reason that was not heard for so long is said again: the robot was well in between."""
_NUMBER = re.compile(r"[-+]?[\d.]+(?:e[-+]?\d+)?|\b(?:nan|inf)\b")

_LOG = logging.getLogger(__name__)


class Refusals:
    """Counts refused messages of one kind; for the one thread that hears them.

    Args:
        what: what they are, for the words: "a scan".
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self.counts: Counter[str] = Counter()
        """By reason, with the numbers of the first one of its kind."""
        self._named: dict[str, str] = {}
        self._last_ns: dict[str, int] = {}

    def count(self, reason: str, now_ns: int = 0) -> None:
        """Note another one, by the clock of arrivals."""
        kind = _NUMBER.sub("#", reason)
        if kind not in self._named and len(self._named) >= MOST_REASONS:
            kind = reason = "for other reasons"
        self.counts[self._named.setdefault(kind, reason)] += 1
        last_ns = self._last_ns.get(kind)
        self._last_ns[kind] = now_ns
        if last_ns is None or now_ns - last_ns > AGAIN_NS:
            _LOG.warning("%s of the robot is refused: %s (said once)", self._what, reason)
