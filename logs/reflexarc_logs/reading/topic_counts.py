"""How many messages a log holds of each topic, how large, and from when to when."""

from collections.abc import Iterable
from dataclasses import dataclass

from mcap.records import Channel, Schema

from reflexarc_logs.container.writing import SENDER
from reflexarc_runtime.messages.wire import NO_SENDER


@dataclass(frozen=True)
class TopicSummary:
    """One topic of a log."""

    topic: str
    schema: str
    messages: int
    payload_bytes: int | None
    """None: its index alone was read, which does not say."""
    rate_hz: float
    """Messages a second between the first and the last; 0 with fewer than two."""
    senders: int
    """How many different ones sent it; 0 in logs that do not say."""


@dataclass
class TopicCount:
    """A channel, or all channels of a topic, counted."""

    topic: str
    schema: str
    senders: set[str]
    messages: int
    payload_bytes: int | None
    first_ns: int
    last_ns: int

    @classmethod
    def of(
        cls,
        channel: Channel,
        schema: Schema,
        messages: int,
        payload_bytes: int | None,
        first_ns: int,
        last_ns: int,
    ) -> "TopicCount":
        """The count of one channel."""
        senders = {channel.metadata.get(SENDER, "")} - {"", NO_SENDER.hex()}
        return cls(channel.topic, schema.name, senders, messages, payload_bytes, first_ns, last_ns)

    def add(self, payload_bytes: int, log_ns: int) -> None:
        """Count one message more."""
        self.messages += 1
        self.payload_bytes = (self.payload_bytes or 0) + payload_bytes
        self.first_ns = min(self.first_ns, log_ns)
        self.last_ns = max(self.last_ns, log_ns)

    def join(self, other: "TopicCount") -> None:
        """Take in another channel of the same topic."""
        self.senders |= other.senders
        self.messages += other.messages
        if self.payload_bytes is not None and other.payload_bytes is not None:
            self.payload_bytes += other.payload_bytes
        self.first_ns = min(self.first_ns, other.first_ns)
        self.last_ns = max(self.last_ns, other.last_ns)

    @property
    def summary(self) -> TopicSummary:
        """In numbers."""
        seconds = (self.last_ns - self.first_ns) * 1e-9
        rate_hz = (self.messages - 1) / seconds if seconds > 0 else 0.0
        return TopicSummary(
            topic=self.topic,
            schema=self.schema,
            messages=self.messages,
            payload_bytes=self.payload_bytes,
            rate_hz=rate_hz,
            senders=len(self.senders),
        )


@dataclass(frozen=True)
class StreamCounts:
    """All topics of a log."""

    topics: tuple[TopicSummary, ...]
    """By name."""
    messages: int
    first_ns: int
    """Log time of the first message; 0 without any."""
    last_ns: int

    @property
    def duration_s(self) -> float:
        """From the first message to the last one."""
        return (self.last_ns - self.first_ns) * 1e-9

    @classmethod
    def of(cls, channels: Iterable[TopicCount]) -> "StreamCounts":
        """The channels of a log, those of one topic together."""
        topics: dict[str, TopicCount] = {}
        for channel in channels:
            if channel.topic in topics:
                topics[channel.topic].join(channel)
            else:
                topics[channel.topic] = channel
        return cls(
            topics=tuple(topics[name].summary for name in sorted(topics)),
            messages=sum(count.messages for count in topics.values()),
            first_ns=min((count.first_ns for count in topics.values()), default=0),
            last_ns=max((count.last_ns for count in topics.values()), default=0),
        )
