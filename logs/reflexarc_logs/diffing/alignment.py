"""Which message of one stream belongs to which of the other.

By their sequence numbers, if these tell messages apart on both sides: a message that is missing
then shifts nothing. Else by when they were sent, if many were sent at the same moment on both
sides, as in two logs of one drive. Else in their order.
"""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_logs.diffing.diff_rules import Alignment
from reflexarc_logs.diffing.message_file import StreamMessage

Key: TypeAlias = Callable[[StreamMessage], int]
Unsigned: TypeAlias = npt.NDArray[np.unsignedinteger[Any]]

_SAMPLE = 1000
"""So many times of sending are looked at to see whether both sides have the same."""


@dataclass
class Census:
    """What one reading of a stream says of its messages."""

    count: int = 0
    first: int = -1
    last: int = -1
    sequences_tell: bool = True
    """Whether every sequence number is greater than the one before."""
    times_tell: bool = True
    """Whether every message was sent after the one before."""
    last_sent_ns: int = -1
    sent_ns: set[int] = field(default_factory=set)
    """When the first ones were sent."""

    def add(self, sequence: int, sent_ns: int) -> None:
        """Count a message."""
        if not self.count:
            self.first = sequence
        self.sequences_tell &= sequence > self.last
        self.times_tell &= sent_ns > self.last_sent_ns
        self.count, self.last, self.last_sent_ns = self.count + 1, sequence, sent_ns
        if len(self.sent_ns) < _SAMPLE:
            self.sent_ns.add(sent_ns)

    def add_all(self, sequences: Unsigned, sent_ns: Unsigned, shift_ns: int) -> None:
        """Count messages that follow each other.

        Args:
            sequences: of each, (messages,).
            sent_ns: when each was sent, (messages,).
            shift_ns: what has to be taken off those times.
        """
        if not self.count:
            self.first = int(sequences[0])
        self.sequences_tell &= int(sequences[0]) > self.last and _grows(sequences)
        self.times_tell &= int(sent_ns[0]) - shift_ns > self.last_sent_ns and _grows(sent_ns)
        self.count, self.last = self.count + len(sequences), int(sequences[-1])
        self.last_sent_ns = int(sent_ns[-1]) - shift_ns
        for begin in range(0, len(sent_ns), _SAMPLE):  # of those that are the same, one counts
            if (wanted := _SAMPLE - len(self.sent_ns)) <= 0:
                return
            some = [sent - shift_ns for sent in sent_ns[begin : begin + _SAMPLE].tolist()]
            new = [sent for sent in dict.fromkeys(some) if sent not in self.sent_ns]
            self.sent_ns.update(new[:wanted])


def _grows(values: Unsigned) -> bool:
    return bool((values[1:] > values[:-1]).all())


def chosen(asked: Alignment, one: Census, other: Census) -> Alignment:
    """By what two streams are paired; never `auto`."""
    if asked != "auto":
        return asked
    overlap = one.first <= other.last and other.first <= one.last
    if one.sequences_tell and other.sequences_tell and overlap:
        return "sequence"
    enough = min(len(one.sent_ns), len(other.sent_ns)) / 2
    if one.times_tell and other.times_tell and len(one.sent_ns & other.sent_ns) >= enough:
        return "publish-time"
    return "order"


class Matched(NamedTuple):
    """What belongs together; None: that side has nothing."""

    number: int
    """How many pairs of the stream came before it."""
    a: StreamMessage | None
    b: StreamMessage | None


class Pairing:
    """Pairs the messages of two streams as they come.

    Args:
        how: by what.
    """

    def __init__(self, how: Alignment) -> None:
        self.how = how
        self._key: Key | None = None
        if how != "order":
            self._key = _sequence if how == "sequence" else _sent_ns
        self._waiting: tuple[deque[StreamMessage], deque[StreamMessage]] = (deque(), deque())
        self._number = 0

    def add(self, side: int, message: StreamMessage) -> Iterator[Matched]:
        """Take a message of side 0 or 1; yields what is certain now."""
        ours, theirs = self._waiting
        self._waiting[side].append(message)
        while ours and theirs:
            yield self._take()

    def rest(self) -> Iterator[Matched]:
        """What has nothing to belong to, when both streams have ended."""
        for side, waiting in enumerate(self._waiting):
            while waiting:
                yield self._alone(side)

    def _take(self) -> Matched:
        ours, theirs = self._waiting
        if self._key is not None and (gap := self._key(ours[0]) - self._key(theirs[0])):
            return self._alone(0 if gap < 0 else 1)
        return self._pair(ours.popleft(), theirs.popleft())

    def _alone(self, side: int) -> Matched:
        message = self._waiting[side].popleft()
        return self._pair(message, None) if side == 0 else self._pair(None, message)

    def _pair(self, a: StreamMessage | None, b: StreamMessage | None) -> Matched:
        self._number += 1
        return Matched(self._number - 1, a, b)


def _sequence(message: StreamMessage) -> int:
    return message.sequence


def _sent_ns(message: StreamMessage) -> int:
    return message.publish_ns
