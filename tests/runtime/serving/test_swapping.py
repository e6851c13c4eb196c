"""One policy takes over from another: when, what it begins with, and how a fault brings it back."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, Serving, State
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.inertia import Moving
from reflexarc_runtime.keyframe import decode_state, encode_state
from reflexarc_runtime.messages.controls import encode_overrun, encode_stop, encode_swap
from reflexarc_runtime.messages.topics import OVERRUN, RESET, STOP, SWAP, Topic
from reflexarc_runtime.messages.wire import Message, protobuf_encoding
from reflexarc_runtime.policy.policy import Policy, RememberingPolicy
from reflexarc_runtime.rules import CURRENT_RULES, RULES, ControllerRules
from reflexarc_runtime.sensing.senses import RetinaSense
from reflexarc_runtime.serving.swapping import SwappingController, says_rolled_back
from support.policies import SMALL, AddingPolicy, FailingPolicy, ScriptedPolicy
from support.sensing import MS, retina_message

PERIOD_NS = 20 * MS
LEFT, RIGHT = (0.1, 0.9, 0.2), (0.1, 0.2, 0.9)


@dataclass
class Changeable:
    """Says what it is told to say from now on."""

    q_values: tuple[float, ...] = RIGHT

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        values = np.array([self.q_values], np.float32)
        return values, np.array([int(np.nanargmax(values))])


@dataclass
class FailingLater(Changeable):
    """Gives no number from some decision on."""

    left: int = 0

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        self.left -= 1
        if self.left < 0:
            self.q_values = tuple(NAN)
        return super().decide(retinas)


@dataclass
class Loop:
    """A controller and its state, tick by tick, with a good retina at each."""

    others: dict[str, Policy | RememberingPolicy]
    first: Policy | RememberingPolicy = field(default_factory=lambda: ScriptedPolicy(LEFT))
    contract: PolicyContract = SMALL
    state: State = field(default_factory=State)
    ticks: int = 0
    rules: ControllerRules = CURRENT_RULES

    def __post_init__(self) -> None:
        sense = RetinaSense(self.contract.retina)
        first = Controller(self.first, self.contract, sense, "old", self.rules)
        known = {
            name: replace(first, policy=policy, policy_hash=name)
            for name, policy in self.others.items()
        }
        self.controller = SwappingController(first, known)

    def tick(self, *messages: Message, count: int = 1, sees: bool = True) -> Decision:
        """So many ticks, the first one with these messages."""
        for _ in range(count):
            now_ns = self.ticks * PERIOD_NS
            seen = (retina_message(self.ticks, now_ns),) * sees
            inputs = Inputs((*messages, *seen), self.ticks)
            self.state, decision = self.controller.step(self.state, inputs, now_ns)
            self.ticks, messages = self.ticks + 1, ()
        return decision


def message(topic: Topic, payload: bytes) -> Message:
    return Message(topic.key("robot0"), payload, protobuf_encoding(topic.schema), b"", 0)


def swap(policy_hash: str, *, while_moving: bool = False) -> Message:
    return message(SWAP, encode_swap(b"", policy_hash, "", while_moving=while_moving))


STOPPED = message(STOP, encode_stop("stand"))
GO_ON = message(RESET, b"")
LATE = message(OVERRUN, encode_overrun(0, 60 * MS))


def ended(policy_hash: str) -> Message:
    """A decision of this policy was ended."""
    return message(OVERRUN, encode_overrun(0, 62 * MS, policy_hash))


NAN: Sequence[float] = (0.1, float("nan"), 0.2)


def test_a_swap_waits_until_the_last_command_was_to_stand():
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    assert loop.tick(count=5).action == 1
    assert loop.tick(swap("new"), count=50).policy_hash == "old"
    assert loop.tick(STOPPED).policy_hash == "old"  # it is told to stand at this tick
    taken = loop.tick()
    assert (taken.policy_hash, taken.verdict.name) == ("new", "STOPPED")
    assert loop.tick(GO_ON, count=5).action == 2


def test_a_swap_waits_until_the_body_is_believed_to_stand():
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(STOPPED)
    rolling = Moving((0.4, 0.0, 0.0), (0.0, 0.0, 0.0), 0)
    loop.state = replace(loop.state, moving=rolling)
    state, decision = loop.controller.step(loop.state, Inputs((swap("new"),), 1), PERIOD_NS)
    assert decision.policy_hash == "old"
    assert state.serving.pending == "new"
    stands = replace(state, moving=Moving((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0))
    assert loop.controller.step(stands, Inputs((), 2), 2 * PERIOD_NS)[1].policy_hash == "new"


def test_told_so_it_takes_over_at_the_next_tick_while_the_body_moves():
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    taken = loop.tick(swap("new", while_moving=True))
    assert (taken.policy_hash, taken.action, taken.verdict.name) == ("new", 2, "OK")


def test_of_two_swaps_the_later_one_counts_and_one_to_who_serves_calls_off_the_other():
    loop = Loop({"new": ScriptedPolicy(RIGHT), "newer": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    loop.tick(swap("new"), swap("newer"))
    assert loop.state.serving.pending == "newer"
    loop.tick(swap("old"))
    assert loop.state.serving == Serving()
    assert loop.tick(STOPPED, count=3).policy_hash == "old"


def test_what_nobody_has_loaded_or_can_be_read_changes_nothing():
    loop = Loop({})
    loop.tick(count=5)
    unreadable = message(SWAP, b"\xff\xff")
    stranger = replace(swap("old", while_moving=True), encoding="text/plain")
    decision = loop.tick(swap("unknown", while_moving=True), unreadable, stranger)
    assert (decision.policy_hash, decision.verdict.name) == ("old", "OK")
    assert loop.state.serving == Serving()


def test_a_policy_that_fails_is_rolled_back_within_its_tick_and_for_good():
    for broken in (FailingPolicy(), Changeable(tuple(NAN))):
        loop = Loop({"new": broken})
        loop.tick(count=5)
        decision = loop.tick(swap("new", while_moving=True))
        assert (decision.policy_hash, decision.action, decision.verdict.name) == ("old", 1, "OK")
        assert says_rolled_back(decision.reason)
        assert decision.reason.startswith("policy new failed (")
        after = loop.tick()
        assert (after.policy_hash, after.reason) == ("old", "")


def test_it_is_rolled_back_also_when_it_fails_long_after_it_took_over():
    changing = Changeable()
    loop = Loop({"new": changing})
    loop.tick(count=5)
    assert loop.tick(swap("new", while_moving=True), count=500).policy_hash == "new"
    changing.q_values = tuple(NAN)
    assert loop.tick().policy_hash == "old"


def test_where_both_fail_the_body_stands():
    loop = Loop({"new": FailingPolicy()}, first=FailingPolicy())
    loop.tick(count=5)
    decision = loop.tick(swap("new", while_moving=True))
    assert (decision.policy_hash, decision.verdict.name) == ("old", "POLICY_FAULT")
    assert decision.command.is_safe


def test_a_policy_whose_first_decision_was_ended_is_rolled_back():
    """What was ended is no tick: its messages come with the next one, then who was ended."""
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    loop.tick(swap("new"), STOPPED, count=2)
    loop.tick(GO_ON, count=2)
    assert loop.state.serving == Serving("new", "old")
    decision = loop.tick(ended("new"), LATE)
    assert decision.policy_hash == "old"
    assert says_rolled_back(decision.reason)
    assert decision.reason == (
        "policy new failed (it gave no answer, its decision was ended): rolled back to old; "
        "a tick was late by 60 ms"
    )


@pytest.mark.parametrize("stalls", [1, 2, 5])
def test_overruns_in_which_no_decision_was_ended_are_the_machines(stalls: int):
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    loop.tick(swap("new"), STOPPED, count=2)
    loop.tick(GO_ON, count=2)  # it would be asked at the next tick
    for _ in range(stalls):
        assert loop.tick(LATE).policy_hash == "new"
    assert loop.tick(count=5).action == 2


def test_a_policy_that_hangs_as_it_takes_over_is_rolled_back_at_that_overrun():
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    decision = loop.tick(swap("new", while_moving=True), ended("new"), LATE)
    assert (decision.policy_hash, decision.verdict.name) == ("old", "OVERRUN")
    assert says_rolled_back(decision.reason)
    assert loop.state.serving == Serving("old")
    assert loop.tick(count=5).action == 1


def test_of_a_policy_that_had_answered_one_ended_decision_is_forgiven():
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    loop.tick(swap("new", while_moving=True), count=5)
    assert loop.tick(ended("new"), LATE).policy_hash == "new"
    assert loop.tick(LATE).policy_hash == "new"  # the machine was late again
    assert loop.tick(count=5).action == 2  # an answer
    assert loop.tick(ended("new")).policy_hash == "new"
    assert loop.tick(ended("new")).policy_hash == "old"  # none since


def test_a_decision_of_another_policy_that_was_ended_is_no_fault_of_the_new_one():
    loop = Loop({"new": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    loop.tick(swap("new", while_moving=True), sees=False)
    assert loop.tick(ended("old"), ended("")).policy_hash == "new"
    unreadable = message(OVERRUN, b"\xff\xff")
    assert loop.tick(unreadable).policy_hash == "new"


def test_a_swap_that_came_after_the_ended_decision_is_of_its_own():
    loop = Loop({"new": ScriptedPolicy(RIGHT), "newer": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    moving = swap("new", while_moving=True)
    decision = loop.tick(moving, ended("new"), LATE, swap("newer", while_moving=True))
    assert says_rolled_back(decision.reason)
    assert loop.state.serving == Serving("newer", "old")
    again = Loop({"new": ScriptedPolicy(RIGHT)})
    again.tick(count=5)
    assert again.tick(moving, ended("new"), LATE, moving).policy_hash == "new"  # asked for anew


def test_under_rules_4_who_has_not_answered_at_an_overrun_and_would_be_asked_hung():
    """Logs of then do not say whose decision was ended; they replay as they were recorded."""
    loop = Loop({"new": ScriptedPolicy(RIGHT)}, rules=RULES[4])
    loop.tick(swap("new"), sees=False)
    assert loop.tick(LATE, sees=False).policy_hash == "new"  # it sees nothing: nobody was asked
    loop.tick(count=5)
    assert loop.tick(LATE).policy_hash == "new"  # it had answered
    loop.tick(count=2)
    decision = loop.tick(LATE)  # and has not since
    assert (decision.policy_hash, decision.reason) == (
        "old",
        "policy new failed (it hung): rolled back to old; a tick was late by 60 ms",
    )


@pytest.mark.parametrize(
    ("version", "expected"), [(4, Serving("old", "", "old")), (5, Serving("old"))]
)
def test_a_roll_back_calls_off_the_swap_to_whom_it_brings_back(version: int, expected: Serving):
    changing = Changeable()
    loop = Loop({"new": changing}, rules=RULES[version])
    loop.tick(count=5)
    loop.tick(swap("new", while_moving=True), count=2)
    loop.tick(swap("old"))  # it waits for standstill
    changing.q_values = tuple(NAN)
    assert says_rolled_back(loop.tick().reason)
    assert loop.state.serving == expected


def test_who_came_back_does_not_take_over_from_itself():
    changing = Changeable()
    loop = Loop({"new": changing}, first=FailingLater(left=12))
    loop.tick(count=5)
    loop.tick(swap("new", while_moving=True))
    loop.tick(swap("old"))
    changing.q_values = tuple(NAN)
    loop.tick()
    loop.tick(STOPPED, count=3)
    loop.tick(GO_ON, count=3)
    fault = loop.tick(count=12)
    assert (fault.verdict.name, says_rolled_back(fault.reason)) == ("POLICY_FAULT", False)


def test_memory_and_held_action_begin_anew():
    contract = replace(SMALL, state=StateSpec(1, (0.0,)), hold_s=1.0)
    new = AddingPolicy()
    loop = Loop({"new": new}, AddingPolicy(), contract)
    loop.tick(count=9)
    assert loop.state.hold is not None
    decision = loop.tick(swap("new", while_moving=True))
    assert (new.given, decision.state) == ([0.0], (0.0,))
    assert loop.state.hold is not None
    assert loop.state.hold.since_slot == decision.slot


def test_a_keyframe_holds_who_serves():
    loop = Loop({"new": ScriptedPolicy(RIGHT), "newer": ScriptedPolicy(RIGHT)})
    loop.tick(count=5)
    loop.tick(swap("new", while_moving=True))
    loop.tick(swap("newer"))
    keyframe = pb.Keyframe.FromString(encode_state(loop.state, "old"))
    assert keyframe.policy_hash == "new"
    again = decode_state(keyframe, SMALL)
    assert again.serving == loop.state.serving == Serving("new", "old", "newer", False, True)
    assert again.drove


def test_it_never_raises_and_is_the_same_twice():
    rng = np.random.default_rng(3)
    words = [swap("new"), swap("bad", while_moving=True), swap("old"), STOPPED, GO_ON, LATE]
    said = [[words[i] for i in rng.integers(len(words), size=rng.integers(3))] for _ in range(400)]
    runs = []
    for _ in range(2):
        loop = Loop({"new": ScriptedPolicy(RIGHT), "bad": FailingPolicy()})
        runs.append([loop.tick(*each, sees=bool(n % 7)) for n, each in enumerate(said)])
    assert runs[0] == runs[1]
    drove = {one.policy_hash for one in runs[0] if not one.command.is_safe}
    assert drove == {"old", "new"}  # the bad one has its turn only while nobody is asked
