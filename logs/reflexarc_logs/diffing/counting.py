"""What the first reading of a file says of its streams: by which of them can its messages pair?"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from reflexarc_logs.diffing.alignment import Census
from reflexarc_logs.diffing.message_file import Stream, StreamMessage, StreamTable


@dataclass
class CountedStream:
    """A stream, and what its first reading says."""

    stream: Stream
    census: Census = field(default_factory=Census)


CountedStreams: TypeAlias = dict[str, CountedStream]
"""By topic."""


def count_messages(messages: Iterable[StreamMessage]) -> CountedStreams:
    """The streams of some messages, by topic."""
    found: CountedStreams = {}
    for message in messages:
        counted = found.get(message.stream.topic)
        if counted is None:
            counted = found[message.stream.topic] = CountedStream(message.stream)
        counted.census.add(message.sequence, message.publish_ns)
    return found


def count_tables(tables: Iterable[StreamTable]) -> CountedStreams:
    """The same of messages in tables: what `count_messages` finds of them one by one."""
    found: CountedStreams = {}
    for one in tables:
        heads = one.table.heads
        numbers, first = np.unique(heads["channel"], return_index=True)
        for number in numbers[np.argsort(first)].tolist():
            stream = one.streams[number]
            counted = found.setdefault(stream.topic, CountedStream(stream))
            rows = heads[heads["channel"] == number]
            counted.census.add_all(rows["sequence"], rows["sent_ns"], one.table.publish_shift_ns)
    return found
