"""What a robot said that cannot be used: counted by reason, and each reason said once."""

import logging
import re
from collections import Counter

MOST_REASONS = 16
"""So many different reasons are counted apart."""

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

    def count(self, reason: str) -> None:
        """Note another one."""
        kind = _NUMBER.sub("#", reason)
        if kind not in self._named and len(self._named) >= MOST_REASONS:
            kind = reason = "for other reasons"
        reason = self._named.setdefault(kind, reason)
        self.counts[reason] += 1
        if self.counts[reason] == 1:
            _LOG.warning("%s of the robot is refused: %s (said once)", self._what, reason)
