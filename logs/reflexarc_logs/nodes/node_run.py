"""Feeds a node from a log, and collects what it says."""

from collections import Counter
from collections.abc import Iterator
from typing import Any

from reflexarc_logs.diffing.message_file import Stream, StreamMessage
from reflexarc_logs.nodes.message_codec import MessageCodec, codec_of, stream_for
from reflexarc_logs.nodes.node_class import NamedNode, NodeCrashError, NodeError
from reflexarc_logs.nodes.node_input import NodeInput, topic_of_stream
from reflexarc_runtime.errors import first_line


class NodeRun:
    """A new node, fed with all of a log but what was recorded on its own topics.

    Args:
        named: the node.
        heard: the log.
        recorded: the stream that was recorded on its topic; None: what it says first says the type.

    Raises:
        NodeError: it cannot be made; there is nothing to feed it with; it says what is no message
            of its topic.
        NodeCrashError: it raised an error.
    """

    def __init__(self, named: NamedNode, heard: NodeInput, recorded: Stream | None) -> None:
        self.outputs: list[StreamMessage] = []
        """What it said on its own topic; log time and time of sending are those of the message
        that led to it. The numbers are all 0: they pair nothing."""
        self.fed: Counter[str] = Counter()
        """How many messages of each topic it was given."""
        self.others: Counter[str] = Counter()
        """How many it said on topics that are not its own."""
        self._named, self._heard, self._stream = named, heard, recorded
        self._codecs: dict[Stream, MessageCodec] = {}
        self._node = named.make()
        self._feed()

    def _feed(self) -> None:
        wanted = self._wanted()
        for message in self._heard.messages(lambda topic: topic in wanted):
            topic = topic_of_stream(message.stream)
            place = f"{topic}, message {self.fed[topic]}, {self._at(message.log_ns)}"
            self.fed[topic] += 1
            given = self._decoded(message, place)
            for said_on, said in self._said(topic, given, message.log_ns, place):
                self._take(said_on, said, message.log_ns, place)
        if not self.fed:
            there = ", ".join(sorted(self._heard.counts)) or "nothing"
            raise NodeError(f"{self._named.name}: nothing to feed it with; the log holds {there}")

    def _wanted(self) -> set[str]:
        """The topics that it is given: those that it names, or all; never its own ones."""
        named = getattr(self._node, "topics", None)
        if isinstance(named, str):
            named = [named]
        return set(self._heard.counts if named is None else named) - {
            self._named.topic,
            *self._named.own,
        }

    def _at(self, log_ns: int) -> str:
        return f"{(log_ns - self._heard.first_ns) * 1e-9:.3f} s into the log"

    def _decoded(self, message: StreamMessage, place: str) -> Any:
        try:
            return self._codec(message.stream).decode(message.payload)
        except NodeError:
            raise
        except Exception as error:  # rosbags raises whatever its generated code meets
            raise NodeError(f"{place}: cannot be decoded: {first_line(error)}") from None

    def _codec(self, stream: Stream) -> MessageCodec:
        if stream not in self._codecs:
            self._codecs[stream] = codec_of(stream)
        return self._codecs[stream]

    def _said(self, topic: str, given: Any, log_ns: int, place: str) -> Iterator[tuple[str, Any]]:
        """What it says of a message, also where it says one thing after the other."""
        try:
            yield from _pairs(self._node.on_message(topic, given, log_ns), self._named.topic)
        except Exception as error:
            raise NodeCrashError(f"{self._named.name} failed at {place}") from error

    def _take(self, topic: str, said: Any, log_ns: int, place: str) -> None:
        if topic != self._named.topic:
            self.others[topic] += 1
            return
        if self._stream is None:
            self._stream = self._new_stream(said)
        try:
            payload = self._codec(self._stream).encode(said)
        except NodeError:
            raise
        except Exception as error:  # of the library that writes the messages
            kind = self._stream.type_name or self._stream.encoding
            raise NodeError(
                f"{self._named.name}: what it says of {place} is no {kind}: {first_line(error)}"
            ) from None
        self.outputs.append(StreamMessage(self._stream, 0, log_ns, log_ns, payload))

    def _new_stream(self, said: Any) -> Stream:
        """The stream of a topic on which nothing was recorded."""
        topic, says = self._named.topic, getattr(self._node, "says", "")
        stream = stream_for(topic, said, says.get(topic, "") if isinstance(says, dict) else says)
        if self._heard.is_of_ros2 and stream.encoding == "json":
            raise NodeError(
                f"{self._named.name}: nothing is recorded on {topic}, so a dictionary is of no "
                'type: say an object, or set `says = "geometry_msgs/msg/Twist"` or the like'
            )
        return stream


def _pairs(said: Any, own: str) -> Iterator[tuple[str, Any]]:
    """Topic and message of each thing that was said."""
    if said is None:
        return
    if _is_pair(said):
        yield said
    elif isinstance(said, list | tuple | Iterator):
        for one in said:
            yield one if _is_pair(one) else (own, one)
    else:
        yield own, said


def _is_pair(said: Any) -> bool:
    return isinstance(said, tuple) and len(said) == 2 and isinstance(said[0], str)
