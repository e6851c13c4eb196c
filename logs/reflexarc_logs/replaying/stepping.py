"""A controller on its way through a log: each recorded tick decided again.

With onnxruntime on either side the values differ by rounding. What they lead to is then taken from
the record after each tick (what the policy remembers, which action is held), so that a difference
is judged where it arises and not at every tick behind it.
"""

from collections import deque
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import Beginning
from reflexarc_logs.replaying.comparison import (
    EqualityRules,
    Tally,
    find_flip,
    is_at_the_edge,
)
from reflexarc_logs.replaying.message_fields import Difference, Fields, message_type
from reflexarc_logs.replaying.recorded_holds import ASKED_VALUES, RecordedHolds
from reflexarc_logs.replaying.report import Flip
from reflexarc_logs.replaying.serving.served_policies import ServedControllers, ServedPolicies
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.arrays import Memories
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, Serving, State
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.guard import Guard, asks_the_input
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.keyframe import encode_state
from reflexarc_runtime.messages.codec import decision_to_protobuf
from reflexarc_runtime.messages.topics import KEYFRAME
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.rules import ControllerRules, rules_of
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import sense_for
from reflexarc_runtime.serving.swapping import AnyController, SwappingController, says_rolled_back

_DRIVING = (Verdict.OK.value, Verdict.GUARDED.value)

WARM_UP_NS = 2_000_000_000
"""How long the memory of another policy than the recorded one warms up."""


def controller_of(
    log: Log, policy: LoadedPolicy, served: ServedPolicies | None = None
) -> AnyController:
    """The controller that decided on a log, with this policy, under the log's rules.

    Args:
        log: the log.
        policy: whom to ask.
        served: who took over; by default, as the log says. A candidate decides all ticks.

    Raises:
        LogError: rules that this package does not know, or settings of a guard that are none.
        ContractError: the policy cannot see what the log's sensor sent.
    """
    contract, guard = policy.contract, None
    if log.run.guard:
        guard = Guard.for_contract(GuardSettings.from_json(log.run.guard), contract)
    rules = rules_of(log.run.rules)
    senses = _senses(log, rules)
    sense = sense_for(log.run.input, contract.retina, senses, guarded=asks_the_input(guard))
    controller = Controller(policy, contract, sense, policy.policy_hash, rules, guard)
    served = served or ServedPolicies(log, policy)
    if not served.are_followed:
        return controller
    return SwappingController(controller, ServedControllers(served, controller))


class TickComparison(NamedTuple):
    """How a tick that was decided again differs."""

    differences: list[Difference]
    flip: Flip | None


@dataclass
class Stepping:
    """A controller on its way through a log."""

    controller: AnyController
    state: State
    waiting: deque[Message]
    """Messages that no tick has taken yet."""
    fields: Fields
    """Fields of a decision that log and package have in common."""
    rules: EqualityRules
    keyframe_fields: Fields | None = None
    """Those of a keyframe; None where none can be compared."""
    is_exact: bool = True
    """Whether the state is the whole one: only then a keyframe can be compared with it."""
    surprises: list[Difference] = field(default_factory=list)
    """What differed from a keyframe; it counts at the next tick."""
    counts_from_ns: int | None = None
    """When the memory of a candidate has warmed up; None: not known yet."""

    def __post_init__(self) -> None:
        state = self.state
        self._holds = RecordedHolds(self.controller.contract, state.hold, state.index)
        self._leans = self.rules.same_policy and not self.rules.exact
        self._has_winner = self.fields.compares("winner")

    @classmethod
    def at(
        cls, beginning: Beginning, policy: LoadedPolicy, log: Log, rules: EqualityRules
    ) -> "Stepping":
        """At a beginning; where there is none, there is nothing to step.

        Raises:
            LogError: rules that this package does not know, or no description of ticks.
        """
        theirs = message_type(log.tick_descriptor(), "decision")
        decisions = Fields(pb.Decision.DESCRIPTOR, theirs)  # type: ignore[arg-type]  # one of two stubs
        keyframes = _keyframe_fields(log) if rules.same_policy else None
        state = beginning.state or State()
        controller = controller_of(log, policy, beginning.served)
        is_exact = beginning.is_exact
        return cls(controller, state, beginning.waiting, decisions, rules, keyframes, is_exact)

    def go_on(self, state: State, *, is_exact: bool) -> None:
        """Go on from another state, behind what is missing."""
        self.state, self.is_exact, self.surprises = state, is_exact, []
        self._holds = RecordedHolds(self.controller.contract, state.hold, state.index)

    def meet(self, keyframe: pb.Keyframe) -> None:
        """Compare what the controller knows with what it knew."""
        if self.keyframe_fields is None or not self.is_exact:
            return
        ours = pb.Keyframe.FromString(encode_state(self.state, self.controller.policy_hash))
        self.surprises += [
            Difference(f"keyframe.{d.path}", d.recorded, d.replayed)
            for d in self.keyframe_fields.differences(keyframe, ours)
            if self.rules.exact or not d.path.startswith("memory")
        ]

    def compare(self, tick: pb.Tick, tally: Tally) -> None:
        """Decide a tick again, and compare it."""
        self.count(tick, self.decide(tick), tally)

    def decide(self, tick: pb.Tick) -> TickComparison:
        """Decide a tick again; how it differs."""
        recorded = tick.decision
        replayed = decision_to_protobuf(self.step(recorded))
        differences = [*self.surprises, *self.fields.differences(recorded, replayed)]
        self.surprises = []
        flip = self._flip(recorded, replayed) if differences else None
        return TickComparison(differences, flip)

    def count(self, tick: pb.Tick, comparison: TickComparison, tally: Tally) -> None:
        """Count a tick that was decided again."""
        tally.ticks += 1
        if self._warms_up(tick.decision):
            tally.warming_up += 1
        else:
            tally.add(tick.decision.index, self.fields.count, *comparison)

    def step(self, recorded: pb.Decision) -> Decision:
        """Decide a tick again."""
        inputs = _inputs(self.waiting, recorded, self.controller.rules)
        before = self.state.serving
        self.state, decision = self.controller.step(self.state, inputs, recorded.now_ns)
        if self._changed_hands(before, decision):
            contract = self.controller.at(self.state).contract
            self._holds = RecordedHolds.anew(contract, recorded.index)
        self._holds.saw(recorded)
        same = recorded.verdict == int(decision.verdict)
        if self._leans and same and recorded.verdict in ASKED_VALUES:
            self._lean_on(recorded)
        return decision

    def _changed_hands(self, before: Serving, decision: Decision) -> bool:
        """Whether another policy decided than at the tick before, or one that began anew."""
        if self.state.serving is before or before.policy_hash == self.state.serving.policy_hash:
            return says_rolled_back(decision.reason)
        return True

    def _lean_on(self, recorded: pb.Decision) -> None:
        """Go on from what was recorded, not from what rounding made of it here."""
        told = recorded.command
        commanded = told.linear_mps, told.lateral_mps, told.angular_radps
        moving = self.state.moving
        if moving is not None:
            moving = replace(moving, commanded=commanded)
        self.state = replace(self.state, hold=self._holds.held, moving=moving)
        deciding = self.controller.at(self.state)
        contract = deciding.contract
        if len(recorded.state) == contract.state.size > 0:
            memory: Memories = np.array([recorded.state], np.float32)
            stack = np.stack(self.state.frames)[np.newaxis]
            following = deciding.policy.decide(stack, memory)[2]  # type: ignore[call-arg, misc]
            self.state = replace(self.state, memory=memory, following=following)

    def _flip(self, recorded: pb.Decision, replayed: pb.Decision) -> Flip | None:
        """Of the winner; or, with the same winner, of what a margin at its edge made of it."""
        if recorded.verdict != replayed.verdict or recorded.verdict not in _DRIVING:
            return None
        index, q_values, tolerance = recorded.index, recorded.q_values, self.rules.tolerance
        if self._has_winner and recorded.winner != replayed.winner:
            return find_flip(index, q_values, recorded.winner, replayed.winner, tolerance)
        contract = self.controller.at(self.state).contract
        flip = find_flip(index, q_values, recorded.action, replayed.action, tolerance)
        if flip is None or not (contract.margin or contract.least_lead):
            return flip
        rounding = is_at_the_edge(q_values, abs(flip.margin), contract, tolerance)
        return replace(flip, rounding=rounding)

    def _warms_up(self, recorded: pb.Decision) -> bool:
        """Whether another policy's memory is not worth a comparison yet."""
        if self.rules.same_policy or not self.controller.contract.state.size:
            return False
        if self.counts_from_ns is None:
            self.counts_from_ns = recorded.now_ns + WARM_UP_NS
        return recorded.now_ns < self.counts_from_ns


def _senses(log: Log, rules: ControllerRules) -> SenseSettings | None:
    """How the loop was told to read what came; a listener on the bus was told nothing."""
    if not rules.checked_senses:
        return None
    return SenseSettings.from_json(log.run.senses) if log.run.senses else SenseSettings()


def _keyframe_fields(log: Log) -> Fields | None:
    theirs = log.descriptor(KEYFRAME.schema)
    if theirs is None:
        return None
    return Fields(pb.Keyframe.DESCRIPTOR, theirs)  # type: ignore[arg-type]  # one of two stubs


def _inputs(waiting: deque[Message], recorded: pb.Decision, rules: ControllerRules) -> Inputs:
    """What the loop had drained; where the log holds less, the count itself will differ."""
    count = min(recorded.inputs, len(waiting))
    messages = tuple([waiting.popleft() for _ in range(count)])
    stop = not rules.stop_is_a_message and recorded.verdict == Verdict.STOPPED.value
    return Inputs(messages, recorded.slot, stop=stop)
