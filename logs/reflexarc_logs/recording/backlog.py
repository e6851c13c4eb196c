"""The queue between the loop and the recorder's thread: bounded in records and in bytes.

The loop puts a whole tick at once, and it is taken out message by message. It takes no lock for
that: whoever holds one may be kept from going on. Nor does it wake the recorder's thread, which
costs as much as everything else: that one looks by itself, at a time when the loop sleeps.
"""

import threading
from collections import deque
from dataclasses import dataclass
from typing import TypeAlias

from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.clock import Clock, MonotonicClock
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.wire import Message

Entry: TypeAlias = Message | Keyframe

MAX_RECORDS = 200_000
MAX_BYTES = 256 << 20
LEAST_NAP_NS, MOST_NAP_NS = 500_000, 20_000_000
"""How long the recorder's thread leaves alone what is empty."""


@dataclass(slots=True)
class Sum:
    """How much it is so far; one thread at a time adds to it."""

    records: int = 0
    bytes: int = 0


@dataclass(slots=True)
class Rhythm:
    """When to look for the next tick: a quarter of a period after it began, when the loop sleeps.

    Whoever looks at any time holds the interpreter's lock now and then just when a tick is due.
    """

    last_ns: int = 0
    period_ns: int = MOST_NAP_NS
    """Between the last two ticks."""

    def saw(self, tick_ns: int) -> None:
        """A tick began at this time."""
        self.period_ns, self.last_ns = max(1, tick_ns - self.last_ns), tick_ns

    def next_look_ns(self, now_ns: int) -> int:
        """When to look again; where a tick is missing, at the time of the one after."""
        since_ns = now_ns - self.last_ns - self.period_ns // 4
        nap_ns = self.period_ns - since_ns % self.period_ns
        return now_ns + min(max(nap_ns, LEAST_NAP_NS), MOST_NAP_NS)


class Backlog:
    """Records that wait to be written. When it is full, new ones are dropped and counted.

    Args:
        max_records: how many may wait.
        max_bytes: of how much payload.
        clock: by which whoever takes them waits; ticks have their times by the same one, or else
            are looked for at other times.
    """

    def __init__(
        self,
        max_records: int = MAX_RECORDS,
        max_bytes: int = MAX_BYTES,
        clock: Clock | None = None,
    ) -> None:
        self._clock: Clock = clock or MonotonicClock()
        self._rhythm = Rhythm()
        self._entries: deque[Entry | TickRecord] = deque()
        self._unfolded: deque[Message] = deque()
        """The rest of a tick of which some messages have been taken."""
        self._max_records = max_records
        self._max_bytes = max_bytes
        self._ticks, self._others, self._taken = Sum(), Sum(), Sum()
        """What was put by the loop, and by others, and what was taken. They only grow."""
        self._lock = threading.Lock()  # of the others, held for an addition
        self.dropped = 0
        self._is_ending = False
        self.ended = False
        """Everything up to the end has been taken."""

    @property
    def waiting(self) -> int:
        """Records that wait, about."""
        return self._ticks.records + self._others.records - self._taken.records

    def put(self, entry: Entry) -> None:
        """Add a record, or count it as dropped; from any thread, without waiting."""
        with self._lock:
            is_room = self._count(self._others, 1, _size(entry))
        if is_room:
            self._entries.append(entry)

    def put_tick(self, record: TickRecord) -> None:
        """Add all of a tick, or count all of it as dropped; from the loop's thread alone."""
        if self._count(self._ticks, *record.extent()):
            self._entries.append(record)

    def end(self) -> None:
        """Say that no more will come."""
        self._is_ending = True

    def take(self, timeout_s: float) -> Entry | None:
        """Take the oldest record, waiting for one; None when the time or the queue is over."""
        if not self._unfolded:
            entry = self._oldest(self._clock.now_ns() + round(timeout_s * 1e9))
            if not isinstance(entry, TickRecord):
                return None if entry is None else self._count_taken(entry)
            self._rhythm.saw(entry.now_ns)
            self._unfolded.extend(entry.messages())
        return self._count_taken(self._unfolded.popleft())

    def _oldest(self, until_ns: int) -> Entry | TickRecord | None:
        """The oldest entry, looking for one now and then until a time."""
        while True:
            is_ending = self._is_ending  # asked first: what was put before it is still there then
            if self._entries:
                return self._entries.popleft()
            now_ns = self._clock.now_ns()
            if is_ending or now_ns >= until_ns:
                self.ended = is_ending
                return None
            self._clock.sleep_until_ns(min(until_ns, self._rhythm.next_look_ns(now_ns)))

    def _count(self, put: "Sum", records: int, size: int) -> bool:
        """Count what is about to be put; whether there is room for it, or it is dropped."""
        ticks, others, taken = self._ticks, self._others, self._taken
        waiting = ticks.records + others.records - taken.records
        waiting_bytes = ticks.bytes + others.bytes - taken.bytes
        if waiting + records > self._max_records or waiting_bytes + size > self._max_bytes:
            self.dropped += records
            return False
        put.records += records
        put.bytes += size
        return True

    def _count_taken(self, entry: Entry) -> Entry:
        self._taken.records += 1
        self._taken.bytes += _size(entry)
        return entry


def _size(entry: Entry) -> int:
    """Bytes of what was received; a keyframe shares its arrays with the loop."""
    return len(entry.payload) if isinstance(entry, Message) else 0
