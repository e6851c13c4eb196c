"""Says on the terminal that an inbox overflows: at most once for each time that it is asked."""

import logging

_LOG = logging.getLogger(__name__)


class FloodNotice:
    """Remembers how much was said to be lost.

    Args:
        what: whose inbox it is, as the line begins.
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._said = 0

    def look(self, overflows: int) -> None:
        """Say it, if more messages were lost since the last look."""
        if overflows > self._said:
            _LOG.warning(
                "%s: flooded: %d messages dropped since the last notice, %d in all",
                self._what,
                overflows - self._said,
                overflows,
            )
        self._said = overflows
