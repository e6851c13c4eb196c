"""What happened in a log that a person would look at: contacts, guards, stops, overruns, marks."""

from collections.abc import Iterator, Sequence
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
    tick_topic, *beside = incident_topics(log)
    finder = IncidentFinder(log)
    for record in log.records(tick_topic, *beside):
        if record.topic == tick_topic:
            yield from finder.tick(decode(log, record, Tick).decision, record.log_ns)
        else:
            finder.beside(record)
    yield from finder.end()


def incident_topics(log: Log) -> tuple[str, str, str]:
    """What an `IncidentFinder` is fed with: ticks; and beside them contacts and marks."""
    return log.topic(TICK.name), log.topic(CONTACT.name), log.topic(MARK.name)


class IncidentFinder:
    """Finds incidents in records that somebody else reads.

    Args:
        log: whose records they are.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._mark = log.topic(MARK.name)
        self._known: IncidentKind | None = None
        self._waiting: list[tuple[IncidentKind, int, str]] = []
        self._last: int | None = None

    def beside(self, record: Record) -> None:
        """Take a contact or a mark.

        Raises:
            LogError: it is none.
        """
        kind: IncidentKind = "mark" if record.topic == self._mark else "contact"
        self._waiting.append((kind, record.log_ns, _words(self._log, record)))

    def tick(self, decision: Decision, log_ns: int) -> Sequence[Incident]:
        """Take the next tick; what happened before it, and at it."""
        before, self._last = self._last, decision.index
        now = _KIND_OF.get(decision.verdict)
        if now is None and self._known is None and not self._waiting:
            return ()  # nearly always
        found = self._let_go(decision.index if before is None else before)
        if now is not None and now != self._known and not _is_end(decision):
            found.append(Incident(now, decision.index, log_ns, decision.reason[:_SHOWN]))
        self._known = None if _is_end(decision) else now
        return found

    def end(self) -> Sequence[Incident]:
        """What happened behind the last tick."""
        return () if self._last is None else self._let_go(self._last)

    def _let_go(self, tick: int) -> list[Incident]:
        found = [Incident(kind, tick, log_ns, words) for kind, log_ns, words in self._waiting]
        self._waiting.clear()
        return found


def _is_end(decision: Decision) -> bool:
    """Whether it is the stop that ends every run."""
    return decision.verdict == int(Verdict.STOPPED) and END_OF_RUN in decision.reason


def _words(log: Log, record: Record) -> str:
    """What a contact or a mark says."""
    if record.topic == log.topic(MARK.name):
        return decode(log, record, FoxgloveLog).message[:_SHOWN]
    contact = decode(log, record, Contact)
    return f"number {contact.count}, at {contact.x_m:.2f}, {contact.y_m:.2f} m"
