"""What the controller remembers for a policy, holds for a body, and keeps standing for a stop."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import NO_WINNER, SAFE_ACTION, Decision, Verdict
from reflexarc_runtime.messages.controls import encode_stop
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Reset
from reflexarc_runtime.policy.policy import Policy, RememberingPolicy
from reflexarc_runtime.rules import RULES
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, AddingPolicy, ScriptedPolicy
from support.sensing import MS, retina_message

REMEMBERING = replace(SMALL, state=StateSpec(1, (0.5,)), recovery_inputs=2)
PERIOD_NS = 20 * MS


def steps(
    batches: list[list[Message]], policy: Policy | RememberingPolicy, contract: PolicyContract
) -> list[Decision]:
    """One tick for each batch, a period after the one before."""
    controller = Controller(policy, contract, RetinaSense(contract.retina), "hash")
    state, decisions = State(), []
    for slot, batch in enumerate(batches):
        inputs = Inputs(tuple(batch), slot)
        state, decision = controller.step(state, inputs, slot * PERIOD_NS + 10 * MS)
        decisions.append(decision)
    return decisions


def seen(slot: int, value: int = 1) -> list[Message]:
    return [retina_message(slot, slot * PERIOD_NS, value=value)]


def control(topic: str, payload: bytes, encoding: str) -> Message:
    stamp = pack_stamp(Stamp(0, 0))
    return Message(f"robot0/{topic}", payload, protobuf_encoding(encoding), stamp, 0)


STOP = control("stop", encode_stop("somebody is in the way"), "reflexarc.Stop")
RESET = control("reset", Reset(reason="go on").SerializeToString(), "reflexarc.Reset")


def test_a_memory_begins_with_its_start_value_and_grows_by_each_accepted_input():
    policy = AddingPolicy()
    decisions = steps([seen(s, value=3) for s in range(5)], policy, REMEMBERING)
    assert policy.given == [0.5, 3.5, 6.5, 9.5]  # the first tick recovers
    assert [d.state for d in decisions] == [(), (0.5,), (3.5,), (6.5,), (9.5,)]
    assert decisions[1].q_values == (3.5, -3.5, 0.0)


def test_a_repeated_retina_decides_again_from_the_same_memory():
    policy = AddingPolicy()
    batches = [seen(0), seen(1), [], seen(1), seen(2)]  # none, and the same one twice
    decisions = steps(batches, policy, REMEMBERING)
    assert policy.given == [0.5, 0.5, 0.5, 1.5]
    assert decisions[1].q_values == decisions[2].q_values == decisions[3].q_values


def test_several_inputs_in_one_tick_are_one_decision_and_one_step_of_the_memory():
    policy = AddingPolicy()
    steps([seen(0), seen(1), [*seen(2), *seen(3), *seen(4)], seen(5)], policy, REMEMBERING)
    assert policy.given == [0.5, 1.5, 2.5]


def test_after_any_fault_a_memory_begins_anew():
    policy = AddingPolicy()
    broken = [replace(seen(3)[0], payload=b"\xff")]
    batches = [seen(0), seen(1), seen(2), broken, seen(4), seen(5), seen(6)]
    decisions = steps(batches, policy, REMEMBERING)
    assert policy.given == [0.5, 1.5, 0.5, 1.5]
    assert decisions[3].verdict is Verdict.INVALID_INPUT


def test_a_memory_that_is_not_finite_is_a_fault_and_begins_anew():
    class Overflowing(AddingPolicy):
        def decide(self, retinas, memories):
            q_values, actions, following = super().decide(retinas, memories)
            is_third = len(self.given) == 3
            return np.zeros_like(q_values), actions, following * np.inf if is_third else following

    policy = Overflowing()
    decisions = steps([seen(s) for s in range(6)], policy, REMEMBERING)
    assert policy.given == [0.5, 1.5, 2.5, 0.5, 1.5]
    assert decisions[3].verdict is Verdict.POLICY_FAULT
    assert decisions[3].state == (2.5,)
    assert decisions[3].command.is_safe


class Flickering(ScriptedPolicy):
    """Prefers another action at every decision."""

    def decide(self, retinas):
        self.q_values = [(0.0, 1.0, 0.9), (0.0, 0.9, 1.0)][len(self.given) % 2]
        return super().decide(retinas)


def test_a_held_action_is_done_and_the_winner_is_said():
    contract = replace(SMALL, hold_s=0.06, recovery_inputs=1)
    decisions = steps([seen(s) for s in range(7)], Flickering(), contract)
    assert [d.winner for d in decisions] == [1, 2, 1, 2, 1, 2, 1]
    assert [d.action for d in decisions] == [1, 1, 1, 2, 2, 2, 1]
    assert [d.command.action for d in decisions] == [d.action for d in decisions]
    assert decisions[1].command.lateral_mps == SMALL.actions[1].lateral_mps


def test_a_margin_keeps_an_action_that_is_almost_as_good():
    contract = replace(SMALL, margin=0.2, recovery_inputs=1)
    decisions = steps([seen(s) for s in range(5)], Flickering(), contract)
    assert [d.action for d in decisions] == [1] * 5


def test_any_verdict_but_ok_ends_a_hold():
    contract = replace(SMALL, hold_s=10.0, recovery_inputs=1)
    broken = [replace(seen(2)[0], payload=b"\xff")]
    decisions = steps([seen(0), seen(1), broken, seen(3), seen(4)], Flickering(), contract)
    assert [d.action for d in decisions] == [1, 1, SAFE_ACTION, 1, 1]
    assert [d.winner for d in decisions] == [1, 2, NO_WINNER, 1, 2]


def test_a_stop_holds_until_a_reset_and_then_good_inputs_must_come_in_a_row():
    batches = [*[seen(s) for s in range(3)], [*seen(3), STOP], seen(4), [*seen(5), RESET]]
    batches += [seen(s) for s in range(6, 10)]
    decisions = steps(batches, ScriptedPolicy(), SMALL)
    names = [d.verdict.name for d in decisions]
    assert names[2:5] == ["OK", "STOPPED", "STOPPED"]
    assert names[5:] == ["RECOVERING", "RECOVERING", "RECOVERING", "OK", "OK"]
    assert decisions[3].reason == decisions[4].reason == "somebody is in the way"
    assert [d.inputs for d in decisions[2:6]] == [1, 2, 1, 2]


@pytest.mark.parametrize("payload", [b"", b"\xff\xff", b"\x00" * 100])
def test_whatever_comes_on_the_key_of_a_stop_stops(payload):
    stop = replace(STOP, payload=payload, encoding="text/plain", attachment=b"")
    decisions = steps([*[seen(s) for s in range(3)], [stop]], ScriptedPolicy(), SMALL)
    assert decisions[-1].verdict is Verdict.STOPPED
    assert decisions[-1].reason


@pytest.mark.parametrize("changes", [{"payload": b"\xff"}, {"encoding": "text/plain"}])
def test_only_what_is_a_reset_ends_a_stop(changes):
    batches = [[STOP], [replace(RESET, **changes)], *[seen(s) for s in range(2, 6)]]
    decisions = steps(batches, ScriptedPolicy(), SMALL)
    assert {d.verdict for d in decisions} == {Verdict.STOPPED}


def test_under_the_first_rules_a_stop_came_beside_the_inputs():
    contract = SMALL
    sense = RetinaSense(contract.retina)
    controller = Controller(ScriptedPolicy(), contract, sense, "hash", RULES[1])
    _, decision = controller.step(State(), Inputs((), 0, stop=True), 0)
    assert (decision.verdict, decision.reason) == (Verdict.STOPPED, "asked to stop")


@settings(max_examples=40, deadline=None)
@given(st.lists(st.sampled_from(["seen", "same", "none", "broken", "stop", "reset"]), max_size=40))
def test_the_memory_is_the_sum_of_what_was_decided_on_since_the_last_fault(events):
    """A slow account of the rule, kept beside the controller."""
    policy, batches, slot = AddingPolicy(), [], 0
    for event in events:
        slot += event == "seen"
        broken = [replace(seen(slot)[0], payload=b"\xff")]
        batches.append(
            {"seen": seen(slot), "same": seen(slot), "none": [], "broken": broken}
            | {"stop": [STOP], "reset": [RESET]}
        )
    batches = [batch[event] for batch, event in zip(batches, events, strict=True)]
    decisions = steps(batches, policy, replace(REMEMBERING, max_input_age_s=10.0))
    expected, last = 0.5, None
    for decision in decisions:
        if decision.verdict is not Verdict.OK:
            expected, last = 0.5, None
            continue
        assert decision.input is not None
        now = decision.input.sequence
        expected += 1.0 if last is not None and now != last else 0.0
        assert decision.state == (expected,)
        last = now
