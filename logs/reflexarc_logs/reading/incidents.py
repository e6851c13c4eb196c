"""What happened in a log that a person would look at: contacts, guards, stops, overruns, marks."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

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
MOST_TICKS_BACK = 64
"""What happened is no farther behind its tick."""
_MOST_TICKS_AHEAD = 8
"""So many ticks are waited for that may stand behind a contact that came after them."""


@dataclass(frozen=True, slots=True)
class Incident:
    """Something that happened."""

    kind: IncidentKind
    tick: int
    """Index of the tick at which it began; of a contact or a mark, the last one before it: by the
    body's clock where that is the loop's, too (in lockstep), else in the file's order."""
    log_ns: int
    words: str
    """What the log says of it; may be empty."""
    behind: int = -1
    """The tick that it stands behind in the file, where that is a later one: who cuts it out needs
    that one, too."""


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
        self._is_lockstep = log.run.clock == "lockstep"
        self._known: IncidentKind | None = None
        self._waiting: list[_Beside] = []
        self._last: int | None = None
        self._looks: deque[tuple[int, int]] = deque(maxlen=MOST_TICKS_BACK)
        """Index of each tick in lockstep, and the time of the look that it decided on."""

    def beside(self, record: Record) -> None:
        """Take a contact or a mark.

        Raises:
            LogError: it is none.
        """
        kind: IncidentKind = "mark" if record.topic == self._mark else "contact"
        happened_ns = record.publish_ns if self._is_lockstep and kind == "contact" else None
        words = _words(self._log, record)
        self._waiting.append(_Beside(kind, record.log_ns, words, self._last, happened_ns))

    def tick(self, decision: Decision, log_ns: int) -> Sequence[Incident]:
        """Take the next tick; what happened before it, and at it."""
        if self._is_lockstep and decision.HasField("input"):
            self._looks.append((decision.index, decision.input.source_time_ns))
        before, self._last = self._last, decision.index
        now = _KIND_OF.get(decision.verdict)
        if now is None and self._known is None and not self._waiting:
            return ()  # nearly always
        found = self._let_go(decision.index if before is None else before, decision.index)
        if now is not None and now != self._known and not _is_end(decision):
            found.append(Incident(now, decision.index, log_ns, decision.reason[:_SHOWN]))
        self._known = None if _is_end(decision) else now
        return found

    def end(self) -> Sequence[Incident]:
        """What happened behind the last tick."""
        return () if self._last is None else self._let_go(self._last)

    def _let_go(self, tick: int, newest: int | None = None) -> list[Incident]:
        """What is certain now; all, if there is no newest tick: the log is over."""
        waiting, self._waiting = self._waiting, []
        found = []
        for one in waiting:
            place = tick if one.behind is None else one.behind
            if newest is not None and self._may_come_yet(one, newest - place):
                self._waiting.append(one)
            else:
                tick_then = self._looked_before(one, place)
                behind = place if place > tick_then else -1
                found.append(Incident(one.kind, tick_then, one.log_ns, one.words, behind))
        return found

    def _may_come_yet(self, one: "_Beside", ticks: int) -> bool:
        """Whether a tick that decided before it happened may stand behind it in the file."""
        if one.happened_ns is None or ticks >= _MOST_TICKS_AHEAD:
            return False
        return not self._looks or self._looks[-1][1] < one.happened_ns

    def _looked_before(self, one: "_Beside", place: int) -> int:
        """The last tick that decided on a look before it happened; else its place in the file.

        A time that lies before or behind all looks says nothing.
        """
        if one.happened_ns is None or not self._looks or self._looks[-1][1] < one.happened_ns:
            return place
        earlier = (i for i, look_ns in reversed(self._looks) if look_ns < one.happened_ns)
        return next(earlier, place)


class _Beside(NamedTuple):
    """A contact or a mark, of which the tick is not known yet."""

    kind: IncidentKind
    log_ns: int
    words: str
    behind: int | None
    """The tick that it stands behind in the file."""
    happened_ns: int | None
    """On the clock of the body; None: its place in the file counts."""


def _is_end(decision: Decision) -> bool:
    """Whether it is the stop that ends every run."""
    return decision.verdict == int(Verdict.STOPPED) and END_OF_RUN in decision.reason


def _words(log: Log, record: Record) -> str:
    """What a contact or a mark says."""
    if record.topic == log.topic(MARK.name):
        return decode(log, record, FoxgloveLog).message[:_SHOWN]
    contact = decode(log, record, Contact)
    return f"number {contact.count}, at {contact.x_m:.2f}, {contact.y_m:.2f} m"
