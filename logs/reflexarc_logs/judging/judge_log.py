"""Judges a candidate policy on one log: one pass over the file, at level `policy`."""

from collections import deque
from collections.abc import Iterable, Iterator

from reflexarc_logs.judging.answers import Answering, Answers, JudgedTick
from reflexarc_logs.judging.comparable import check_comparable
from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.flip_tally import FlipTally
from reflexarc_logs.judging.incident_answers import IncidentAnswers, TickPlace
from reflexarc_logs.judging.judgement import NO_ACTION, LogJudgement
from reflexarc_logs.reading.incidents import (
    MOST_TICKS_BACK,
    Incident,
    IncidentFinder,
    incident_topics,
)
from reflexarc_logs.reading.reader import Log, decode
from reflexarc_logs.replaying.message_fields import message_type
from reflexarc_logs.replaying.robot_replay import rules_for
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision, Tick
from reflexarc_runtime.policy.policy import LoadedPolicy


def judge_log(
    log: Log, candidate: LoadedPolicy, limits: FlipLimits, name: str = ""
) -> LogJudgement:
    """Judge a candidate on a log.

    Args:
        log: what another policy drove; of a merged log, the robot that it names.
        candidate: whom to ask.
        limits: what it may differ by, and where that is counted.
        name: what the log is called; its file's name if empty.

    Raises:
        LogError: the log cannot be read, holds nothing to judge, or the candidate cannot be judged
            on it.
    """
    notes = check_comparable(log, candidate.contract)
    judging = _Judging(log, candidate, limits)
    judging.run()
    if not judging.tally.counts["ticks"]:
        raise LogError(f"{log.path}: {judging.why_nothing()}")
    contract = candidate.contract
    return LogJudgement(
        log=name or log.path.name,
        run_id=log.run.run_id,
        recorded_policy=log.run.policy_hash,
        actions=tuple(action.name for action in contract.actions),
        retina_shape=contract.retina.stack_shape,
        incidents=judging.incidents.result(),
        more_incidents=judging.incidents.more,
        notes=(*notes, *judging.notes()),
        **judging.tally.result(),
    )


class _Judging:
    """One log while it is judged."""

    def __init__(self, log: Log, candidate: LoadedPolicy, limits: FlipLimits) -> None:
        rules = rules_for(log, candidate)
        contract = candidate.contract
        self._log = log
        self._served = ServedPolicies(log, candidate)
        self._sizes = contract.retina.frames * contract.retina.size, len(contract.actions)
        self._answering = Answering(candidate, same_policy=rules.same_policy)
        named = message_type(log.tick_descriptor(), "decision").fields_by_name
        self.tally = FlipTally(limits, rules, contract.actions, has_winner="winner" in named)
        self.incidents = IncidentAnswers()
        self._since, self._until = limits.window
        self._first_ns: int | None = None
        self._here = TickPlace(NO_ACTION, 0, 0)
        self._places: deque[TickPlace] = deque(maxlen=MOST_TICKS_BACK + 1)
        """Of the newest ticks: what happened may be met later."""
        self._ticks = self._other_policies = 0

    def run(self) -> None:
        """Read the whole log."""
        tick_topic, *beside = incident_topics(self._log)
        finder = IncidentFinder(self._log)
        for record in self._log.records(tick_topic, *beside):
            if record.topic != tick_topic:
                finder.beside(record)
            else:
                decision = decode(self._log, record, Tick).decision
                self._here = self._take(decision)
                self._places.append(self._here)
                self._meet(finder.tick(decision, record.log_ns))
        self._meet(finder.end())
        self._count(self._answering.end())

    def notes(self) -> Iterator[str]:
        """What was not judged."""
        if self._other_policies:
            yield f"{self._other_policies} ticks name another policy than the log: not judged"
        if not self._log.complete:
            yield "the log is truncated: its intact part was judged"

    def why_nothing(self) -> str:
        """Why no tick counts."""
        if not self._ticks:
            return "expected ticks, found none; nothing to judge"
        if self.tally.counts["warming_up"]:
            return "it is over before the candidate's memory has warmed up; nothing to judge"
        return (
            "expected ticks at which the policy was asked, found none in the window; "
            f"it has {self._ticks} ticks, the last is {self._here.number} "
            f"({self._here.after_ns / 1e9:.2f} s)"
        )

    def _take(self, decision: Decision) -> TickPlace:
        """Ask about a tick; where it stands."""
        self._ticks += 1
        if self._first_ns is None:
            self._first_ns = decision.now_ns
        after_ns, asked = decision.now_ns - self._first_ns, self._here.asked
        counts = self._is_inside(decision.index, after_ns)
        wanted = counts or self._answering.needs_every_tick
        if decision.q_values and wanted and self._is_of_the_policy(decision):
            self._check_sizes(decision)
            asked += 1
            self._count(self._answering.ask(JudgedTick(decision, after_ns, counts)))
        self._answering.passes(decision)
        return TickPlace(decision.index, after_ns, asked)

    def _count(self, batches: Iterable[Answers]) -> None:
        for answers in batches:
            self.tally.add(answers)
            ticks = [tick.decision.index for tick in answers.ticks]
            recorded, winners = self.tally.preferred(answers), answers.winners.tolist()
            self.incidents.answer(ticks, recorded, winners)

    def _meet(self, found: Iterable[Incident]) -> None:
        for incident in found:
            there = (one for one in reversed(self._places) if one.number == incident.tick)
            place = next(there, self._here)
            if self._is_inside(place.number, place.after_ns):
                self.incidents.meet(incident, place)

    def _is_inside(self, index: int, after_ns: int) -> bool:
        if self._since is not None and not self._since.is_reached_by(index, after_ns):
            return False
        return self._until is None or not self._until.is_reached_by(index, after_ns)

    def _is_of_the_policy(self, decision: Decision) -> bool:
        named, other = self._log.run.policy_hash, decision.policy_hash
        if not named or not other or named == other or self._served.knows(other):
            return True
        self._other_policies += 1
        return False

    def _check_sizes(self, decision: Decision) -> None:
        got = len(decision.retina), len(decision.q_values)
        if got != self._sizes:
            raise LogError(
                f"{self._log.path}: tick {decision.index}: the candidate takes and gives "
                f"{self._sizes} (retina bytes, Q-values), the log holds {got}; give one that fits"
            )
