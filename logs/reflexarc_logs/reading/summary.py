"""What `reflexarc info` says of a log: what was recorded, how much, how fast, and is it whole?

A log of over 4 MiB that has an index is counted by it, in a fraction of the time; the CRC of all
its data is checked all the same. Others are read in full.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from mcap.records import Channel, McapRecord, Message, Schema

from reflexarc_logs.container.first_look import Survey, look, refuse
from reflexarc_logs.container.frames import DamagedError, NotReadHereError, TruncatedError
from reflexarc_logs.container.index import Index, read_index
from reflexarc_logs.container.record_stream import whole_records
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.reading.candidates import CandidatesSeen, candidates_seen
from reflexarc_logs.reading.index_counts import counts_by_index, last_chunk_of, records_of_channels
from reflexarc_logs.reading.reader import Log, open_log, read_log
from reflexarc_logs.reading.runtime_status import named_pace, runtime_status
from reflexarc_logs.reading.topic_counts import StreamCounts, TopicCount, TopicSummary
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_runtime.messages.topics import BODY, STATUS

__all__ = ["ForeignSummary", "LogSummary", "TopicSummary", "describe_any", "summarise"]

FULLY_READ_BYTES = 4 << 20
MOST_STATUSES = 1000
"""A runtime says of its watchdog in its first status, or never."""


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
    """Who drove, in which world, as its last message said it; None: not recorded."""
    guard: GuardSettings | None
    """What looked at each decision, and what it took for granted; None: nothing did."""
    watchdog: str
    """What the runtime said of its own watchdog first; empty: not recorded."""
    realtime: str
    """What it said then of what it had asked of the kernel; empty: nothing."""
    pace: str
    """When its ticks began: `rate`, `input` or `lockstep`; empty: not recorded."""
    topics: tuple[TopicSummary, ...]
    """By name."""
    by_index: bool = False
    """Whether its index was counted, and not its messages."""
    candidates: CandidatesSeen | None = None
    """Who served beside the first policy, and who watched; None: nobody."""

    @property
    def policy_hash(self) -> str:
        """SHA-256 of the attached policy; empty without one."""
        return self.run.policy_hash


@dataclass(frozen=True)
class ForeignSummary:
    """A log of another system in numbers."""

    path: str
    profile: str
    """What its writer says that it follows: "ros2"."""
    library: str
    complete: bool
    damage: str
    """Why it is not complete; empty if it is."""
    bytes: int
    messages: int
    first_ns: int
    """Log time of its first message."""
    duration_s: float
    topics: tuple[TopicSummary, ...]
    attachments: tuple[str, ...]
    metadata: tuple[str, ...]
    ours: bool = False


def describe_any(path: Path | str) -> "LogSummary | ForeignSummary":
    """The numbers of a log of reflexarc, or of one of any other system.

    Raises:
        LogError: it is missing or not MCAP; or it is ours and damaged.
    """
    found = look(Path(path))
    if found.is_ours or not (found.profile or found.metadata or found.complete):
        refuse(found)
        return summarise(open_log(found))
    if not found.is_mcap:
        refuse(found)
    counts = _by_index(found.path, found.complete, found.size)[0]
    if counts is None:
        counts = _all_of_foreign(found)
    return ForeignSummary(
        path=str(path),
        profile=found.profile,
        library=found.library,
        complete=found.complete,
        damage=found.damage,
        bytes=found.size,
        messages=counts.messages,
        first_ns=counts.first_ns,
        duration_s=counts.duration_s,
        topics=counts.topics,
        attachments=tuple(found.places),
        metadata=tuple(found.metadata),
    )


def _all_of_foreign(found: Survey) -> StreamCounts:
    try:
        return _counted(whole_records(found.path, found.intact_size, found.size))[0]
    except (DamagedError, NotReadHereError) as error:
        raise LogError(
            f"{found.path}: a log of another system, not all readable: {error}"
        ) from None


def summarise(log: Log | Path | str) -> LogSummary:
    """Count a log, finished or truncated; the CRC of all its data is checked.

    Raises:
        LogError: it is missing, not MCAP, damaged, or of another system.
    """
    source = log if isinstance(log, Log) else read_log(log, allow_truncated=True)
    counts, said = _by_index(source.path, source.complete, source.size, source)
    by_index = counts is not None
    if counts is None:
        counts, said = _counted(source.mcap_records(), source)
    return LogSummary(
        path=str(source.path),
        complete=source.complete,
        bytes=source.size,
        messages=counts.messages,
        duration_s=counts.duration_s,
        dropped=source.dropped,
        run=source.run,
        body=None if said.body is None else decode_body(said.body),
        guard=GuardSettings.from_json(source.run.guard) if source.run.guard else None,
        watchdog=said.watchdog,
        realtime=said.realtime,
        pace=source.run.pace or said.pace,
        topics=counts.topics,
        by_index=by_index,
        candidates=candidates_seen(source, [topic.topic for topic in counts.topics]),
    )


@dataclass
class _Said:
    """What two topics of a log say, as far as it was read."""

    body_topic: str = ""
    status_topic: str = ""
    body: bytes | None = None
    """The last message of a body. It may be built anew for the runtime whose log it is: what it
    said before is of another one."""
    watchdog: str = ""
    realtime: str = ""
    pace: str = ""

    @classmethod
    def of(cls, log: Log | None) -> "_Said":
        return cls() if log is None else cls(log.topic(BODY.name), log.topic(STATUS.name))

    def hear(self, topic: str, schema: str, payload: bytes) -> None:
        if topic == self.body_topic:
            self.body = payload if schema == BODY.schema else None
        elif topic == self.status_topic and schema == STATUS.schema and not self.watchdog:
            status = runtime_status(payload) or pb.Status()
            self.watchdog, self.realtime = status.watchdog, status.realtime
            self.pace = named_pace(status)


def _counted(records: Iterable[McapRecord], log: Log | None = None) -> tuple[StreamCounts, _Said]:
    """Count all messages, one by one."""
    schemas: dict[int, Schema] = {0: Schema(0, b"", "", "")}
    channels: dict[int, Channel] = {}
    counts: dict[int, TopicCount] = {}
    said = _Said.of(log)
    for record in records:
        match record:
            case Schema():
                schemas[record.id] = record
            case Channel():
                channels[record.id] = record
            case Message():
                count = counts.get(record.channel_id)
                if count is None:
                    number = record.channel_id
                    lost = Channel(number, f"(channel {number}, whose record is lost)", "", {}, 0)
                    channel = channels.get(number, lost)
                    schema = schemas.get(channel.schema_id, schemas[0])
                    at_ns = record.log_time
                    count = TopicCount.of(channel, schema, 0, 0, at_ns, at_ns)
                    counts[record.channel_id] = count
                count.add(len(record.data), record.log_time)
                said.hear(count.topic, count.schema, record.data)
    return StreamCounts.of(counts.values()), said


def _by_index(
    path: Path, complete: bool, size: int, log: Log | None = None
) -> tuple[StreamCounts | None, _Said]:
    """Count by the index, where that is worth it and the index says enough."""
    said = _Said.of(log)
    index = read_index(path) if complete and size > FULLY_READ_BYTES else None
    if index is None:
        return None, said
    try:
        counts = counts_by_index(path, index)
        _hear(path, index, said)
    except (DamagedError, TruncatedError, NotReadHereError, OSError):
        return None, said  # then it is read
    return (StreamCounts.of(counts.values()) if counts else None), said


def _hear(path: Path, index: Index, said: _Said) -> None:
    """What body and runtime say, from the chunks that hold it."""
    of_body = {n for n, channel in index.channels.items() if channel.topic == said.body_topic}
    of_status = {n for n, channel in index.channels.items() if channel.topic == said.status_topic}
    left = MOST_STATUSES
    for record in last_chunk_of(path, index, of_body):
        _tell(index, said, record, of_body)
    for record in records_of_channels(path, index, of_status):
        _tell(index, said, record, of_status)
        left -= isinstance(record, Message) and record.channel_id in of_status
        if said.watchdog or left <= 0:
            break


def _tell(index: Index, said: _Said, record: McapRecord, channels: set[int]) -> None:
    if isinstance(record, Message) and record.channel_id in channels:
        channel = index.channels[record.channel_id]
        schema = index.schemas.get(channel.schema_id)
        said.hear(channel.topic, "" if schema is None else schema.name, record.data)
