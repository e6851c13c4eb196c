"""What a robot said that cannot be used: counted by reason, and each reason said once."""

import logging
from collections import Counter

MOST_REASONS = 16
"""So many different reasons are counted apart."""

_LOG = logging.getLogger(__name__)


class Refusals:
    """Counts refused messages of one kind; for the one thread that hears them.

    Args:
        what: what they are, for the words: "a scan".
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self.counts: Counter[str] = Counter()

    def count(self, reason: str) -> None:
        """Note another one."""
        if reason not in self.counts and len(self.counts) >= MOST_REASONS:
            reason = "for other reasons"  # their numbers differ, and memory is bounded
        self.counts[reason] += 1
        if self.counts[reason] == 1:
            _LOG.warning("%s of the robot is refused: %s (said once)", self._what, reason)
