"""The robot's scans, passed on to our bus as they come."""

import logging
import re
from collections import Counter
from typing import TYPE_CHECKING

from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.messages import (
    STANDARD,
    RosScanner,
    UnusableMessageError,
    decode_scan,
    encode_scan,
)

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher

MOST_REASONS = 16
"""So many different reasons are counted apart."""

_AGAIN_NS = 60_000_000_000
"""A reason that was not heard for so long is said again: the robot was well in between."""
_NUMBER = re.compile(r"[\d.]+")

_LOG = logging.getLogger(__name__)


class ScanRelay:
    """Passes on every scan that can be used, and counts the others by reason.

    Args:
        publisher: of our own scans.
        scanner: what is known of the robot's scanner.
    """

    def __init__(self, publisher: "Publisher", scanner: RosScanner = STANDARD) -> None:
        self._publisher, self._scanner = publisher, scanner
        self.scans = 0
        self.refused: Counter[str] = Counter()
        self._words: dict[str, str] = {}
        self._last_ns: dict[str, int] = {}

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        try:
            payload = encode_scan(decode_scan(message.payload, self._scanner))
        except UnusableMessageError as error:
            self._refuse(str(error), message.received_ns)
            return
        self.scans += 1
        self._publisher.put(payload, message.received_ns)

    def _refuse(self, reason: str, now_ns: int) -> None:
        """Count a refusal under the first words of its kind, which differ in their numbers."""
        kind = _NUMBER.sub("#", reason)
        if kind not in self._words and len(self._words) >= MOST_REASONS:
            kind = reason = "for other reasons"  # memory is bounded
        self.refused[self._words.setdefault(kind, reason)] += 1
        last_ns = self._last_ns.get(kind)
        self._last_ns[kind] = now_ns
        if last_ns is None or now_ns - last_ns > _AGAIN_NS:
            _LOG.warning("a scan of the robot is refused: %s (said once)", reason)
