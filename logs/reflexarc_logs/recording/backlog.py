"""The queue between the loop and the recorder's thread: bounded in records and in bytes."""

import queue
import threading
from typing import TypeAlias

from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.messages.wire import Message

Entry: TypeAlias = Message | Keyframe

MAX_RECORDS = 200_000
MAX_BYTES = 256 << 20


class Backlog:
    """Records that wait to be written. When it is full, new ones are dropped and counted."""

    def __init__(self, max_records: int = MAX_RECORDS, max_bytes: int = MAX_BYTES) -> None:
        self._queue: queue.SimpleQueue[Entry | None] = queue.SimpleQueue()
        self._max_records = max_records
        self._max_bytes = max_bytes
        self._bytes = 0
        self._lock = threading.Lock()  # held for an addition, never while waiting or writing
        self.dropped = 0
        self.ended = False
        """Everything up to the end has been taken."""

    @property
    def waiting(self) -> int:
        """Records that wait, about."""
        return self._queue.qsize()

    def put(self, entry: Entry) -> None:
        """Add a record, or count it as dropped; from any thread, without waiting."""
        size = _size(entry)
        with self._lock:
            full = self._queue.qsize() >= self._max_records
            if full or self._bytes + size > self._max_bytes:
                self.dropped += 1
                return
            self._bytes += size
        self._queue.put(entry)

    def end(self) -> None:
        """Say that no more will come."""
        self._queue.put(None)

    def take(self, timeout_s: float) -> Entry | None:
        """Take the oldest record, waiting for one; None when the time or the queue is over."""
        try:
            entry = self._queue.get(timeout=max(0.0, timeout_s))
        except queue.Empty:
            return None
        if entry is None:
            self.ended = True
            return None
        with self._lock:
            self._bytes -= _size(entry)
        return entry


def _size(entry: Entry) -> int:
    """Bytes of what was received; a keyframe shares its arrays with the loop."""
    return len(entry.payload) if isinstance(entry, Message) else 0
