"""What happened in a log that a person would look at: contacts, guards, stops, overruns, marks."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, TypeAlias

from foxglove_schemas_protobuf.Log_pb2 import Log as FoxgloveLog

from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.loop.node import END_OF_RUN
from reflexarc_runtime.messages.topics import CONTACT, MARK, TICK
from reflexarc_runtime.messages_pb2 import Contact, Decision, Tick

IncidentKind: TypeAlias = Literal["contact", "guard", "stop", "overrun", "mark"]

_KIND_OF: dict[int, IncidentKind] = {
    Verdict.GUARDED: "guard",
    Verdict.STUCK: "guard",
    Verdict.STOPPED: "stop",
    Verdict.OVERRUN: "overrun",
}
_SHOWN = 100


@dataclass(frozen=True, slots=True)
class Incident:
    """Something that happened."""

    kind: IncidentKind
    tick: int
    """Index of the tick at which it began; of a contact or a mark, the last one before it."""
    log_ns: int
    words: str
    """What the log says of it; may be empty."""


def find_incidents(log: Log) -> Iterator[Incident]:
    """All that happened, in file order. The stop that ends every run is none.

    Args:
        log: the log; where it holds no ticks, nothing is found.

    Raises:
        LogError: the log cannot be read.
    """
    tick_topic, contact, mark = (log.topic(t.name) for t in (TICK, CONTACT, MARK))
    known: IncidentKind | None = None
    waiting: list[tuple[IncidentKind, Record, str]] = []
    last: int | None = None
    for record in log.records(tick_topic, contact, mark):
        if record.topic != tick_topic:
            kind: IncidentKind = "contact" if record.topic == contact else "mark"
            waiting.append((kind, record, _words(log, record)))
        else:
            decision = decode(log, record, Tick).decision
            before, last = last, decision.index
            for kind, beside, words in waiting:
                yield Incident(kind, last if before is None else before, beside.log_ns, words)
            waiting.clear()
            now = _kind_of(decision)
            if now is not None and now != known:
                yield Incident(now, decision.index, record.log_ns, decision.reason[:_SHOWN])
            known = now
    for kind, beside, words in waiting if last is not None else ():
        yield Incident(kind, last or 0, beside.log_ns, words)


def _kind_of(decision: Decision) -> IncidentKind | None:
    is_end = decision.verdict == int(Verdict.STOPPED) and END_OF_RUN in decision.reason
    return None if is_end else _KIND_OF.get(decision.verdict)


def _words(log: Log, record: Record) -> str:
    """What a contact or a mark says."""
    if record.topic == log.topic(MARK.name):
        return decode(log, record, FoxgloveLog).message[:_SHOWN]
    contact = decode(log, record, Contact)
    return f"number {contact.count}, at {contact.x_m:.2f}, {contact.y_m:.2f} m"
