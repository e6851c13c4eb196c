"""What a loop would decide now where a log says what it decided then: tick by tick, in order.

Unlike a replay nothing is taken back from the record: each tick goes on from the one before it.
"""

from collections import Counter
from dataclasses import dataclass, field

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import Beginning, begin, keep
from reflexarc_logs.replaying.comparison import EqualityRules
from reflexarc_logs.replaying.log_account import LogAccount
from reflexarc_logs.replaying.loop_events import LoopEvent, loop_events
from reflexarc_logs.replaying.node_level import why_not
from reflexarc_logs.replaying.stepping import Stepping
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.keyframe import encode_state
from reflexarc_runtime.messages.codec import decision_to_protobuf
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import LoadedPolicy

_ADVICE = "it cannot be decided anew; record it again"


@dataclass
class DecidedAnew:
    """The decisions of now, and how they differ from those that were recorded."""

    ticks: list[bytes] = field(default_factory=list)
    """Each tick of the log, in order, as it is to be written."""
    keyframes: list[bytes] = field(default_factory=list)
    """Each keyframe of the log, in order."""
    commands: dict[bytes, bytes] = field(default_factory=dict)
    """Recorded commands → those of now."""
    different: int = 0
    """Ticks that are decided otherwise."""
    counts: Counter[str] = field(default_factory=Counter)
    """Those among them, by what differs first: winner, verdict, …"""
    first: str = ""
    """The first difference, in words."""


def decide_anew(log: Log, policy: LoadedPolicy) -> DecidedAnew:
    """Decide every tick of a log again.

    Args:
        log: what one loop recorded, from its beginning or from a keyframe on.
        policy: who decides.

    Raises:
        LogError: the log cannot be read, or something is missing in it.
        ContractError: the policy cannot see what the log's sensor sent.
    """
    account = LogAccount(log, counts_all=False)
    for _ in account.ticks():
        pass
    if obstacle := why_not(log) or account.why_no_loop():
        raise LogError(f"{log.path}: {obstacle}: {_ADVICE}")
    beginning, events = begin(log, loop_events(log), policy)
    if beginning.state is None or beginning.skipped_ticks or not beginning.is_exact:
        raise LogError(f"{log.path}: nothing tells what its controller knew first: {_ADVICE}")
    anew = _Anew(log, policy, beginning)
    for event in events:
        anew.take(event)
    return anew.found


class _Anew:
    """A controller on its way through a log."""

    def __init__(self, log: Log, policy: LoadedPolicy, beginning: Beginning) -> None:
        rules = EqualityRules(exact=True, same_policy=True)
        self._log, self._policy = log, policy
        self._stepping = Stepping.at(beginning, policy, log, rules)
        self.found = DecidedAnew()
        first = next(event for event in loop_events(log) if not isinstance(event, Message))
        if isinstance(first, pb.Keyframe):  # the beginning was found in it: it is behind us
            self._check(first.index, 0)
            self.found.keyframes.append(self._keyframe())

    def take(self, event: LoopEvent) -> None:
        """Take what came next."""
        if isinstance(event, Message):
            keep(self._stepping.waiting, event, self._log)
        elif isinstance(event, pb.Keyframe):
            self._check(event.index, 0)
            self.found.keyframes.append(self._keyframe())
        else:
            self._check(event.decision.index, event.decision.inputs)
            self._decide(event)

    def _check(self, index: int, inputs: int) -> None:
        expected = self._stepping.state.index
        if index != expected or len(self._stepping.waiting) < inputs:
            raise LogError(
                f"{self._log.path}: ticks or inputs are missing before tick {expected}: {_ADVICE}"
            )

    def _keyframe(self) -> bytes:
        return encode_state(self._stepping.state, self._policy.policy_hash)

    def _decide(self, tick: pb.Tick) -> None:
        recorded = tick.decision
        now = decision_to_protobuf(self._stepping.step(recorded))
        self.found.ticks.append(pb.Tick(decision=now, timing=tick.timing).SerializeToString())
        told = recorded.command.SerializeToString(), now.command.SerializeToString()
        self.found.commands[told[0]] = told[1]
        differences = [
            one
            for one in self._stepping.fields.differences(recorded, now)
            if one.path != "policy_hash"
        ]
        if differences:
            names = {one.path.partition("[")[0] for one in differences}
            self.found.different += 1
            self.found.counts.update(names & {"winner", "action", "verdict"})
            one = differences[0]
            said = f"tick {recorded.index}, {one.path}: {one.recorded} → {one.replayed}"
            self.found.first = self.found.first or said
