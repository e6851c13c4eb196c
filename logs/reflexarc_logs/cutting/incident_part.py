"""Cuts an incident out of a log, so that it becomes a test of its own.

The part holds what led to the incident and a while around it. It can be narrowed: from the tick
before the action that was done at the incident was chosen, up to where it is over, that is all that
a replay needs to show it.
"""

from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.cutting.cut import CutReport, cut
from reflexarc_logs.cutting.span import TickSpan
from reflexarc_logs.reading.incidents import Incident, IncidentKind, find_incidents
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.replaying.report import ReplayReport
from reflexarc_runtime.decision import ASKED
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision

INCIDENT = "reflexarc.incident"
"""Metadata of a part: what it shows, at which tick, of which log."""


@dataclass(frozen=True)
class IncidentPart:
    """An incident as a log of its own."""

    incident: Incident
    part: CutReport
    report: ReplayReport
    """Of the part, replayed."""
    is_shown: bool
    """Whether the part still holds the incident."""
    note: str


@dataclass(frozen=True)
class _Moment:
    """What is known of a tick."""

    index: int
    now_ns: int
    verdict: int
    action: int


def choose(log: Log, at: int | None, first: IncidentKind | None) -> Incident:
    """The incident that is meant.

    Args:
        log: the log.
        at: index of a tick; what happened at it, or the tick itself.
        first: else the first one of this kind; None: the first one of all.

    Raises:
        LogError: there is none.
    """
    found = list(find_incidents(log))
    if at is not None:
        there = [one for one in found if one.tick == at]
        return there[0] if there else Incident("mark", at, 0, f"tick {at}")
    wanted = [one for one in found if first in (None, one.kind)]
    if not wanted:
        seen = ", ".join(sorted({one.kind for one in found})) or "none at all"
        raise LogError(
            f"{log.path}: expected {first or 'an incident'}, found {seen}; choose a tick with --at"
        )
    return wanted[0]


def cut_incident(
    log: Log, incident: Incident, around_s: float, out: Path | str, *, narrow: bool = True
) -> IncidentPart:
    """Cut an incident out, and replay what was cut.

    Args:
        log: the whole log.
        incident: one of its incidents.
        around_s: how much is kept before and behind it at most, seconds.
        out: the log to be; it must not exist.
        narrow: keep only what shows it.

    Raises:
        LogError: the log has no such tick, cannot be read, or `out` cannot be written.
        PolicyError, ContractError: the attached policy is not intact.
    """
    moments = _around(log, incident.tick, around_s)
    here = next((n for n, m in enumerate(moments) if m.index == incident.tick), None)
    if here is None:
        raise LogError(f"{log.path}: expected a tick {incident.tick}, found none of that number")
    span = TickSpan(moments[0].index, moments[-1].index + 1)
    if narrow:
        needed = [n for n, m in enumerate(moments) if m.index <= incident.behind]
        span = _narrowed(moments, here, max([here, *needed]))
    note = _note(log, incident)
    part = cut(log, span, out, said={INCIDENT: _described(log, incident, note)})
    shown = _shows(read_log(part.path), incident)
    return IncidentPart(incident, part, replay(part.path), shown, note)


def _around(log: Log, tick: int, around_s: float) -> list[_Moment]:
    """The ticks of a while, and the one that is meant among them."""
    moments = [_moment(one.decision) for one in log.ticks()]
    at_ns = next((m.now_ns for m in moments if m.index == tick), None)
    if at_ns is None:
        return moments
    return [m for m in moments if abs(m.now_ns - at_ns) <= around_s * 1e9]


def _narrowed(moments: list[_Moment], here: int, last: int) -> TickSpan:
    """From the tick before the choice that led to it, to the tick behind the last one it needs.

    Where the policy was asked, what was done at the incident was chosen at the first of the ticks
    in a row that did the same; where it was not asked, nothing was chosen.
    """
    start = here
    if here and moments[here - 1].verdict != moments[here].verdict:
        start = here - 1  # the choice was made before the verdict changed
    choice = _choice(moments[start])
    while start and choice[0] in ASKED and _choice(moments[start - 1]) == choice:
        start -= 1
    end = moments[min(last + 1, len(moments) - 1)]
    return TickSpan(moments[max(0, start - 1)].index, end.index + 1)


def _choice(moment: _Moment) -> tuple[int, int]:
    return moment.verdict, moment.action


def _shows(part: Log, incident: Incident) -> bool:
    """Whether the part holds it; a tick that somebody chose is one."""
    if not incident.log_ns:
        return any(tick.decision.index == incident.tick for tick in part.ticks())
    return any(one == incident for one in find_incidents(part))


def _described(log: Log, incident: Incident, note: str) -> dict[str, str]:
    return {
        "kind": incident.kind,
        "tick": str(incident.tick),
        "words": incident.words,
        "of": log.path.name,
        "run_id": log.run.run_id,
        "note": note,
    }


def _note(log: Log, incident: Incident) -> str:
    said = f": {incident.words}" if incident.words else ""
    what = incident.kind if incident.log_ns else "a moment"
    return f"{what} at tick {incident.tick} of {log.path.name}{said}"


def _moment(decision: Decision) -> _Moment:
    return _Moment(decision.index, decision.now_ns, decision.verdict, decision.action)
