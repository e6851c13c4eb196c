"""Replay at level `node`: the inputs of each tick through the controller, every field compared.

Each tick takes its `inputs` next messages in file order; no time stamp decides what belongs to
which tick. Where the log has a keyframe, what the controller knows is compared with it. Timing is
never compared.
"""

from collections import deque
from dataclasses import dataclass, field

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import Beginning, begin, keep
from reflexarc_logs.replaying.comparison import EqualityRules, Flip, LevelResult, Tally, find_flip
from reflexarc_logs.replaying.loop_events import loop_events
from reflexarc_logs.replaying.message_fields import Difference, Fields, message_type
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.controller import Controller, Inputs, State
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.guard import Guard, GuardSettings
from reflexarc_runtime.keyframe import encode_state
from reflexarc_runtime.messages.codec import decision_to_protobuf
from reflexarc_runtime.messages.topics import REJECTED, SENSORS
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.rules import ControllerRules, rules_of
from reflexarc_runtime.sensing.senses import sense_for

KEYFRAME_FIELDS = Fields(pb.Keyframe.DESCRIPTOR, pb.Keyframe.DESCRIPTOR)  # type: ignore[arg-type]  # one of two stubs

_DRIVING = (Verdict.OK.value, Verdict.GUARDED.value)


def replay_node(
    log: Log, policy: LoadedPolicy, rules: EqualityRules
) -> tuple[LevelResult, list[str]]:
    """Step a controller through the log.

    Returns:
        The result, and what its reader should know.

    Raises:
        LogError: the log cannot be read, or was not recorded by a loop.
    """
    beginning, events = begin(log, loop_events(log), policy)
    theirs = message_type(log.tick_descriptor(), "decision")
    fields = Fields(pb.Decision.DESCRIPTOR, theirs)  # type: ignore[arg-type]  # one of two stubs
    tally = Tally("node", rules, ticks=beginning.skipped_ticks)
    stepping = Stepping.at(beginning, controller_of(log, policy), log)
    for event in events:
        if isinstance(event, Message):
            keep(stepping.waiting, event, log)
        elif isinstance(event, pb.Keyframe):
            stepping.meet(event, exact=rules.exact and rules.same_policy and beginning.is_exact)
        else:
            stepping.compare(event, fields, tally)
    left_over = len(stepping.waiting)
    notes = [f"{left_over} inputs after the last tick"] * bool(left_over)
    return tally.result(fields.not_compared), [*filter(None, [beginning.note]), *notes]


def controller_of(log: Log, policy: LoadedPolicy) -> Controller:
    """The controller that decided on a log, with this policy, under the log's rules.

    Raises:
        LogError: rules that this package does not know, or settings of a guard that are none.
        ContractError: the policy cannot see what the log's sensor sent.
    """
    contract, guard = policy.contract, None
    if log.run.guard:
        guard = Guard.for_contract(GuardSettings.from_json(log.run.guard), contract)
    sense = sense_for(log.run.input, contract.retina, guarded=guard is not None)
    rules = rules_of(log.run.rules)
    return Controller(policy, contract, sense, policy.policy_hash, rules, guard)


@dataclass
class Stepping:
    """A controller on its way through a log."""

    controller: Controller
    log: Log
    state: State
    waiting: deque[Message]
    """Messages that no tick has taken yet."""
    surprises: list[Difference] = field(default_factory=list)
    """What differed from a keyframe; it counts at the next tick."""

    @classmethod
    def at(cls, beginning: Beginning, controller: Controller, log: Log) -> "Stepping":
        """At a beginning; where there is none, there is nothing to step."""
        return cls(controller, log, beginning.state or State(), beginning.waiting)

    def meet(self, keyframe: pb.Keyframe, *, exact: bool) -> None:
        """Compare what the controller knows with what it knew."""
        if not exact:
            return
        ours = pb.Keyframe.FromString(encode_state(self.state, self.controller.policy_hash))
        self.surprises += [
            Difference(f"keyframe.{d.path}", d.recorded, d.replayed)
            for d in KEYFRAME_FIELDS.differences(keyframe, ours)
        ]

    def compare(self, tick: pb.Tick, fields: Fields, tally: Tally) -> None:
        """Decide a tick again, and compare it."""
        recorded = tick.decision
        replayed = decision_to_protobuf(self.step(recorded))
        tally.ticks += 1
        differences = [*self.surprises, *fields.differences(recorded, replayed)]
        self.surprises = []
        flip = _flip(recorded, replayed, tally.rules)
        tally.add(recorded.index, fields.count, differences, flip)

    def step(self, recorded: pb.Decision) -> Decision:
        """Decide a tick again."""
        inputs = _inputs(self.waiting, recorded, self.controller.rules)
        self.state, decision = self.controller.step(self.state, inputs, recorded.now_ns)
        return decision


def why_not(log: Log) -> str:
    """What keeps a log from being replayed at level `node`; empty if nothing does."""
    if log.run.recorded_by == "import":
        return "it was imported from another system; no loop of ours decided on it"
    if log.run.recorded_by != "run":
        return "it was recorded by a listener, whose order is not the loop's"
    if log.dropped:
        return f"{log.dropped} records or chunks are missing in its middle"
    sensor = log.topic(SENSORS[log.run.input].name)
    stream = next(log.records(sensor, log.topic(REJECTED.name)), None)
    if stream is None and any(_took_inputs(tick.decision) for tick in log.ticks()):
        return f"it has no sensor stream ({sensor})"
    return ""


def _took_inputs(decision: pb.Decision) -> bool:
    """Whether a tick took messages of the sensor; the one that stopped it is another one."""
    return bool(decision.inputs) and decision.verdict != Verdict.STOPPED.value


def _inputs(waiting: deque[Message], recorded: pb.Decision, rules: ControllerRules) -> Inputs:
    """What the loop had drained; where the log holds less, the count itself will differ."""
    count = min(recorded.inputs, len(waiting))
    messages = tuple(waiting.popleft() for _ in range(count))
    stop = not rules.stop_is_a_message and recorded.verdict == Verdict.STOPPED.value
    return Inputs(messages, recorded.slot, stop=stop)


def _flip(recorded: pb.Decision, replayed: pb.Decision, rules: EqualityRules) -> Flip | None:
    if recorded.verdict != replayed.verdict or recorded.verdict not in _DRIVING:
        return None
    now, q_values = replayed.action, recorded.q_values
    return find_flip(recorded.index, q_values, recorded.action, now, rules.tolerance)
