"""The queue between the loop and the recorder's thread: bounded in records and in bytes.

The loop puts a whole tick at once, and it is taken out message by message. It takes no lock for
that: whoever holds one may be kept from going on.
"""

import queue
import threading
from collections import deque
from dataclasses import dataclass
from typing import TypeAlias

from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.wire import Message

Entry: TypeAlias = Message | Keyframe

MAX_RECORDS = 200_000
MAX_BYTES = 256 << 20


@dataclass(slots=True)
class Sum:
    """How much it is so far; one thread at a time adds to it."""

    records: int = 0
    bytes: int = 0


class Backlog:
    """Records that wait to be written. When it is full, new ones are dropped and counted."""

    def __init__(self, max_records: int = MAX_RECORDS, max_bytes: int = MAX_BYTES) -> None:
        self._queue: queue.SimpleQueue[Entry | TickRecord | None] = queue.SimpleQueue()
        self._unfolded: deque[Message] = deque()
        """The rest of a tick of which some messages have been taken."""
        self._max_records = max_records
        self._max_bytes = max_bytes
        self._ticks, self._others, self._taken = Sum(), Sum(), Sum()
        """What was put by the loop, and by others, and what was taken. They only grow."""
        self._lock = threading.Lock()  # of the others, held for an addition
        self.dropped = 0
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
            self._queue.put(entry)

    def put_tick(self, record: TickRecord) -> None:
        """Add all of a tick, or count all of it as dropped; from the loop's thread alone."""
        if self._count(self._ticks, *record.extent()):
            self._queue.put(record)

    def end(self) -> None:
        """Say that no more will come."""
        self._queue.put(None)

    def take(self, timeout_s: float) -> Entry | None:
        """Take the oldest record, waiting for one; None when the time or the queue is over."""
        if not self._unfolded:
            try:
                entry = self._queue.get(timeout=max(0.0, timeout_s))
            except queue.Empty:
                return None
            if entry is None:
                self.ended = True
                return None
            if not isinstance(entry, TickRecord):
                return self._count_taken(entry)
            self._unfolded.extend(entry.messages())
        return self._count_taken(self._unfolded.popleft())

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
