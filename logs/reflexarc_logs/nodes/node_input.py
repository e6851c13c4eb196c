"""The messages of a log in log order, and those that were recorded on one of its topics."""

from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

from reflexarc_logs.container.first_look import look
from reflexarc_logs.container.index import read_index
from reflexarc_logs.diffing.message_file import MessageFile, Stream, StreamMessage


def topic_of_stream(stream: Stream) -> str:
    """Its topic as its publishers name it: a second channel of a topic is no second topic."""
    return stream.topic.partition("#")[0]


def topics_in(path: Path) -> frozenset[str]:
    """The topics of a log.

    Raises:
        LogError: it cannot be read.
    """
    index = read_index(path)
    if index is not None and index.channels:
        return frozenset(channel.topic for channel in index.channels.values())
    return frozenset(topic_of_stream(message.stream) for message in MessageFile(path).messages())


def is_of_another_system(path: Path) -> bool:
    """Whether a log is intact enough to say so, and not ours.

    Raises:
        LogError: it cannot be read.
    """
    found = look(path)
    return found.is_mcap and not found.is_ours and found.complete


class NodeInput:
    """A log as a node hears it.

    Args:
        path: the log.
    """

    def __init__(self, path: Path) -> None:
        self._file = MessageFile(path)
        self.first_ns = 0
        """Log time of the earliest message."""
        self.counts: Counter[str] = Counter()
        """Messages by topic."""
        self.is_of_ros2 = False
        """Whether any of them is written as ROS 2 does."""
        self._is_sorted = True
        last_ns = -1
        for message in self._file.messages():
            self._is_sorted &= message.log_ns >= last_ns
            self.is_of_ros2 |= message.stream.encoding == "cdr"
            last_ns = message.log_ns
            self.first_ns = min(self.first_ns, last_ns) if self.counts else last_ns
            self.counts[topic_of_stream(message.stream)] += 1
        self.was_cut = self._file.was_cut

    def messages(self, is_wanted: Callable[[str], bool]) -> Iterator[StreamMessage]:
        """Those on the wanted topics, by log time; of equal times in file order."""
        wanted = (m for m in self._file.messages() if is_wanted(topic_of_stream(m.stream)))
        yield from wanted if self._is_sorted else sorted(wanted, key=lambda m: m.log_ns)

    def recorded(self, topic: str) -> list[StreamMessage]:
        """What was recorded on a topic; of several channels as if it were one."""
        found = list(self.messages(lambda name: name == topic))
        return [message._replace(stream=found[0].stream) for message in found]
