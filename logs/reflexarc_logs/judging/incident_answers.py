"""What a candidate prefers where something happened: at the last tick that a policy was asked."""

from array import array
from typing import NamedTuple

from reflexarc_logs.judging.judgement import NO_ACTION, IncidentAnswer
from reflexarc_logs.reading.incidents import Incident

MOST_INCIDENTS = 200
"""Incidents of a log that are kept; the others are counted."""


class TickPlace(NamedTuple):
    """A tick, and how many ticks were asked about up to it."""

    number: int
    after_ns: int
    """Since the log's first tick."""
    asked: int


class IncidentAnswers:
    """Incidents as they are met, and the answers as they come, which may be later."""

    def __init__(self) -> None:
        self._ticks, self._recorded, self._candidate = array("q"), array("h"), array("h")
        self._met: list[tuple[Incident, TickPlace]] = []
        self.more = 0
        """Incidents that are not kept."""

    def meet(self, incident: Incident, place: TickPlace) -> None:
        """Take an incident and its tick."""
        if len(self._met) < MOST_INCIDENTS:
            self._met.append((incident, place))
        else:
            self.more += 1

    def answer(self, ticks: list[int], recorded: list[int], candidate: list[int]) -> None:
        """Take what was preferred at the next ticks that were asked about."""
        self._ticks.extend(ticks)
        self._recorded.extend(recorded)
        self._candidate.extend(candidate)

    def result(self) -> tuple[IncidentAnswer, ...]:
        """The incidents with their answers, when all were given."""
        return tuple(self._answered(*one) for one in self._met)

    def _answered(self, incident: Incident, place: TickPlace) -> IncidentAnswer:
        asked = NO_ACTION, NO_ACTION, NO_ACTION
        if place.asked:
            n = place.asked - 1
            asked = self._ticks[n], self._recorded[n], self._candidate[n]
        return IncidentAnswer(
            incident.kind, incident.tick, place.after_ns / 1e9, incident.words, *asked
        )
