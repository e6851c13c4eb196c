"""What `reflexarc info` says of a log: what was recorded, how much, how fast, and is it whole?"""

from dataclasses import dataclass, field
from pathlib import Path

from google.protobuf.message import DecodeError

from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.reading.reader import Log, Record, read_log
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_runtime.messages.topics import BODY, RUNTIME_NODE, STATUS
from reflexarc_runtime.messages.wire import NO_SENDER


@dataclass(frozen=True)
class TopicSummary:
    """One topic of a log."""

    topic: str
    schema: str
    messages: int
    payload_bytes: int
    rate_hz: float
    """Messages a second between the first and the last; 0 with fewer than two."""
    senders: int
    """How many different ones sent it; 0 in logs that do not say."""


@dataclass(frozen=True)
class LogSummary:
    """A log in numbers."""

    path: str
    complete: bool
    """Finished; or truncated, and these are the numbers of its intact part."""
    bytes: int
    messages: int
    duration_s: float
    """From the first message to the last one, by arrival."""
    dropped: int
    """Records or chunks that are missing in the middle."""
    run: RunInfo
    body: BodyInfo | None
    """Who drove, in which world, as its first message said it; None: not recorded."""
    guard: GuardSettings | None
    """What looked at each decision, and what it took for granted; None: nothing did."""
    watchdog: str
    """What the runtime said of its own watchdog first; empty: not recorded."""
    topics: tuple[TopicSummary, ...]
    """By name."""

    @property
    def policy_hash(self) -> str:
        """SHA-256 of the attached policy; empty without one."""
        return self.run.policy_hash


@dataclass
class _Count:
    """A topic while it is counted."""

    first: Record
    last: Record
    first_ns: int
    last_ns: int
    messages: int = 0
    payload_bytes: int = 0
    senders: set[bytes] = field(default_factory=set)

    def add(self, record: Record) -> None:
        self.last = record
        self.messages += 1
        self.payload_bytes += len(record.payload)
        self.senders.add(record.sender)
        self.first_ns = min(self.first_ns, record.log_ns)
        self.last_ns = max(self.last_ns, record.log_ns)


def summarise(log: Log | Path | str) -> LogSummary:
    """Count a log, finished or truncated; reads all of it and checks every CRC.

    Raises:
        LogError: it is missing, not MCAP, damaged, or of another system.
    """
    source = log if isinstance(log, Log) else read_log(log, allow_truncated=True)
    counts: dict[str, _Count] = {}
    for record in source.records():
        count = counts.get(record.topic)
        if count is None:
            count = counts[record.topic] = _Count(record, record, record.log_ns, record.log_ns)
        count.add(record)
    first_ns = min((c.first_ns for c in counts.values()), default=0)
    last_ns = max((c.last_ns for c in counts.values()), default=0)
    return LogSummary(
        path=str(source.path),
        complete=source.complete,
        bytes=source.size,
        messages=sum(c.messages for c in counts.values()),
        duration_s=(last_ns - first_ns) * 1e-9,
        dropped=source.dropped,
        run=source.run,
        body=_body(counts.get(source.topic(BODY.name))),
        guard=GuardSettings.from_json(source.run.guard) if source.run.guard else None,
        watchdog=next(filter(None, map(_watchdog, source.records(source.topic(STATUS.name)))), ""),
        topics=tuple(_topic(name, counts[name]) for name in sorted(counts)),
    )


def _topic(name: str, count: _Count) -> TopicSummary:
    seconds = (count.last_ns - count.first_ns) * 1e-9
    rate_hz = (count.messages - 1) / seconds if seconds > 0 else 0.0
    return TopicSummary(
        topic=name,
        schema=count.first.schema,
        messages=count.messages,
        payload_bytes=count.payload_bytes,
        rate_hz=rate_hz,
        senders=len(count.senders - {NO_SENDER}),
    )


def _watchdog(record: Record) -> str:
    """What a runtime says of its watchdog; empty in what anybody else says."""
    if record.schema != STATUS.schema:
        return ""
    try:
        status = pb.Status.FromString(record.payload)
    except DecodeError:
        return ""
    return status.watchdog if status.node == RUNTIME_NODE else ""


def _body(count: _Count | None) -> BodyInfo | None:
    """What the last message of a body says; None without one that can be read.

    A body may be built anew for the runtime whose log it is: what it said before is of another one.
    """
    if count is None or count.last.schema != BODY.schema:
        return None
    return decode_body(count.last.payload)
