"""What a log's sensors sent, as it came from the bus; what a loop of then did is left out."""

from collections import Counter
from collections.abc import Iterator

from reflexarc_logs.container.rejected import accepted_message, rejected_message
from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_runtime.messages.topics import OVERHEARD, REJECTED, SENSORS, Topic
from reflexarc_runtime.messages.wire import Message, Stamp
from reflexarc_runtime.messages_pb2 import Rejected


def sensors_of(log: Log) -> tuple[str, ...]:
    """The sensors of whose messages a log holds at least one: `retina`, `scan`."""
    found = {record.topic for record in _firsts(log)}
    return tuple(name for name, topic in SENSORS.items() if log.topic(topic.name) in found)


class SensorMessages:
    """The messages of some sensors in a log, and of all that is recorded beside them.

    Args:
        log: the log.
        sensors: what the loop listens to.
    """

    def __init__(self, log: Log, sensors: tuple[Topic, ...]) -> None:
        self._log = log
        self._keys = {topic.key(log.run.robot) for topic in sensors}
        self._beside = {topic.key(log.run.robot) for topic in OVERHEARD}
        self.left_out: Counter[str] = Counter()
        """How many messages of each topic were not handed out."""

    def reaches_the_loop(self, message: Message) -> bool:
        """Whether the loop listens to it, or it is only recorded."""
        return message.key in self._keys

    def __iter__(self) -> Iterator[Message]:
        """In file order."""
        for record in self._log.records():
            message = self._message(record)
            if message is None or message.key not in self._keys | self._beside:
                self.left_out[record.topic] += 1
                continue
            yield message

    def _message(self, record: Record) -> Message | None:
        received_ns = record.log_ns - self._log.run.wall_offset_ns
        if received_ns < 0:
            return None
        if record.topic == self._log.topic(REJECTED.name):
            return rejected_message(decode(self._log, record, Rejected), received_ns)
        stamp = Stamp(record.sequence, record.publish_ns, record.sender)
        key = record.topic.removeprefix("/")
        return accepted_message(key, record.schema, record.payload, stamp, received_ns)


def _firsts(log: Log) -> Iterator[Record]:
    for topic in SENSORS.values():
        first = next(log.records(log.topic(topic.name)), None)
        if first is not None:
            yield first
