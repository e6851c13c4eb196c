"""The course of one stream of a log: its period, its silences, its numbers, its clock.

Memory does not grow with the log but for one number every two seconds: intervals are counted in
classes a fiftieth wide.
"""

import math
from collections import Counter

from reflexarc_logs.checking.delay_course import DelayCourse

MOST_PERIODS = 5
"""A silence of more is a gap; a body stands still by then, at the usual contract."""
LEAST_MESSAGES = 20
"""Fewer have no period."""
LEAST_BACK_NS = 1_000_000
"""Two threads of a recorder may cross by less."""
_CLASSES = 50
_LATE = 64
"""A message may come behind so many that were sent after it."""
_IRREGULAR = 2.0
"""Of what comes regularly, nine of ten intervals are shorter than so many medians."""


class StreamCourse:
    """One stream, message by message in file order.

    Args:
        topic: its name.
    """

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self.count = 0
        self.first_ns = self.last_ns = 0
        """Log times of the first and of the latest message."""
        self.longest_ns = self.longest_at_ns = 0
        """The longest silence, and when it began."""
        self.backs = self.most_back_ns = 0
        """How often log time went back, and by how much at most."""
        self.delays = DelayCourse()
        self.sent_backs = self.most_sent_back_ns = 0
        """The same of the times of sending."""
        self._sent_ns = self._sequence = 0
        self._counted_on = self._absent = 0
        self._intervals: Counter[int] = Counter()

    def add(self, sequence: int, log_ns: int, sent_ns: int) -> None:
        """Take the next message."""
        if self.count:
            self._follow(sequence, log_ns, sent_ns)
        else:
            self.first_ns = self.last_ns = log_ns
        self.count += 1
        self.last_ns = max(self.last_ns, log_ns)
        self._sent_ns, self._sequence = sent_ns, sequence
        self.delays.add(log_ns, sent_ns)

    def _follow(self, sequence: int, log_ns: int, sent_ns: int) -> None:
        interval_ns = log_ns - self.last_ns
        if interval_ns > self.longest_ns:
            self.longest_ns, self.longest_at_ns = interval_ns, self.last_ns
        elif -interval_ns > LEAST_BACK_NS:
            self.backs += 1
            self.most_back_ns = max(self.most_back_ns, -interval_ns)
        self._intervals[_class_of(interval_ns)] += 1
        if sent_ns < self._sent_ns:
            self.sent_backs += 1
            self.most_sent_back_ns = max(self.most_sent_back_ns, self._sent_ns - sent_ns)
        self._count_on(sequence - self._sequence)

    def _count_on(self, jump: int) -> None:
        """Numbers that were jumped over, less those that came late; a restart begins anew."""
        self._counted_on += jump == 1
        if jump and jump > -_LATE:
            self._absent += jump - 1

    @property
    def period_ns(self) -> float | None:
        """The median interval; None of what comes at no regular time."""
        if self.count < LEAST_MESSAGES:
            return None
        usual = self._quantile(0.5)
        return usual if usual > 0 and self._quantile(0.9) <= _IRREGULAR * usual else None

    @property
    def gap_ns(self) -> int:
        """The longest silence, if it is a gap; else 0."""
        period = self.period_ns
        return self.longest_ns if period and self.longest_ns > MOST_PERIODS * period else 0

    @property
    def lost(self) -> int:
        """Messages that are missing by their numbers; 0 where they are not counted one by one."""
        return max(0, self._absent) if 2 * self._counted_on > self.count else 0

    def _quantile(self, share: float) -> float:
        wanted, seen = share * self._intervals.total(), 0
        for number in sorted(self._intervals):
            seen += self._intervals[number]
            if seen >= wanted:
                break
        return 0.0 if number < 0 else 2 ** ((number + 0.5) / _CLASSES)


def _class_of(interval_ns: int) -> int:
    """Its class: 50 to a doubling; −1: no time at all."""
    return int(math.log2(interval_ns) * _CLASSES) if interval_ns > 0 else -1
