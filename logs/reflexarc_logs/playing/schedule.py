"""The schedule of a playback: which messages of a log are sent again, and when.

    due = loop × period + (log_time − first log_time) / speed

The sensor streams of the log's body are sent, in the order of time. One period is the length of the
log plus the mean interval between two scans or retinas, so that a loop continues at the same pace.
Messages of the runtime (commands, ticks, status) and messages that could not be decoded are not
sent again.
"""

import heapq
import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from google.protobuf.message import DecodeError

from reflexarc_logs.reading.reader import Log, Record
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.codec import SCHEMAS
from reflexarc_runtime.messages.topics import BODY_TOPICS, SENSORS, Topic

REORDER_WINDOW_NS = 1_000_000_000
"""A loop records its inputs a tick after they came, and other streams as they come: messages that
are out of order in a log are never further apart than this."""
LONELY_PERIOD_NS = 100_000_000
"""Time after the only sensor message of a log when it is played in a loop."""


@dataclass(frozen=True, slots=True)
class Due:
    """One message to be sent."""

    due_ns: int
    """Since the playing began."""
    loop: int
    """How often the whole log was played before."""
    topic: Topic
    record: Record


@dataclass(frozen=True, slots=True)
class StreamSurvey:
    """The streams of a log that can be played, in numbers."""

    first_ns: int
    """Time of the first message, on the recording's monotonic clock."""
    length_ns: int
    """From the first message to the last one."""
    interval_ns: int
    """Mean time between two sensor messages."""
    messages: int
    undecodable: int
    """Records of these streams that will not be sent."""
    sensor: str
    """Retina or scan: the one that the recorded loop decided on, or the only one in the log."""


@dataclass(slots=True)
class _TopicTimes:
    """First and last time of the messages of one topic, and how many there are."""

    first_ns: int
    last_ns: int
    count: int = 0

    def add(self, time_ns: int) -> None:
        self.first_ns = min(self.first_ns, time_ns)
        self.last_ns = max(self.last_ns, time_ns)
        self.count += 1

    @property
    def interval_ns(self) -> int:
        """Mean time between two messages."""
        length_ns = self.last_ns - self.first_ns
        return length_ns // (self.count - 1) if length_ns else LONELY_PERIOD_NS


def survey_streams(log: Log) -> StreamSurvey:
    """Count the messages of a log that can be played, and measure their times.

    Raises:
        LogError: it has no retina and no scan, or is damaged.
    """
    spans: dict[Topic, _TopicTimes] = {}
    undecodable = 0
    for topic, record in _sensor_records(log):
        if _decodes(topic, record):
            spans.setdefault(topic, _TopicTimes(record.log_ns, record.log_ns)).add(record.log_ns)
        else:
            undecodable += 1
    sensors = {topic.name: span for topic, span in spans.items() if topic.name in SENSORS}
    if not sensors:
        raise LogError(f"{log.path}: expected retinas or scans, found none; nothing to play")
    first_ns = min(span.first_ns for span in spans.values())
    return StreamSurvey(
        first_ns=first_ns - log.run.wall_offset_ns,
        length_ns=max(span.last_ns for span in spans.values()) - first_ns,
        interval_ns=max(sensors.values(), key=lambda span: span.count).interval_ns,
        messages=sum(span.count for span in spans.values()),
        undecodable=undecodable,
        sensor=log.run.input if log.run.input in sensors else min(sensors),
    )


def schedule(
    log: Log, streams: StreamSurvey, *, speed: float = 1.0, loop: bool = False
) -> Iterator[Due]:
    """Every message with the time at which it is due; without end in a loop.

    Args:
        log: read anew for every loop, so that its size does not matter.
        streams: what `survey_streams` found in it.
        speed: how much faster than it was recorded.
        loop: whether to begin again at the end.

    Raises:
        LogError: the log is damaged.
    """
    origin_ns = streams.first_ns + log.run.wall_offset_ns
    period_ns = streams.length_ns + streams.interval_ns
    for number in itertools.count() if loop else range(1):
        for topic, record in _in_order_of_time(_sensor_records(log)):
            if _decodes(topic, record):
                elapsed_ns = number * period_ns + record.log_ns - origin_ns
                yield Due(round(elapsed_ns / speed), number, topic, record)


def _sensor_records(log: Log) -> Iterator[tuple[Topic, Record]]:
    topics = {log.topic(topic.name): topic for topic in BODY_TOPICS}
    for record in log.records(*topics):
        yield topics[record.topic], record


def _decodes(topic: Topic, record: Record) -> bool:
    if record.schema != topic.schema:
        return False
    try:
        SCHEMAS[topic.schema].FromString(record.payload)
    except DecodeError:
        return False
    return True


def _in_order_of_time(
    records: Iterable[tuple[Topic, Record]],
) -> Iterator[tuple[Topic, Record]]:
    """Sorted by log time, and at one time as in the file, as far as the window reaches."""
    waiting: list[tuple[int, int, Topic, Record]] = []
    for number, (topic, record) in enumerate(records):
        heapq.heappush(waiting, (record.log_ns, number, topic, record))
        while record.log_ns - waiting[0][0] > REORDER_WINDOW_NS:
            yield heapq.heappop(waiting)[2:]
    while waiting:
        yield heapq.heappop(waiting)[2:]
