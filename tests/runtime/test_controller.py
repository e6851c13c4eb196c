import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import SAFE_ACTION, Decision, Verdict
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import Policy
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, FailingPolicy, ScriptedPolicy
from support.sensing import MS, SPEC, retina_message

LIMIT_NS = SMALL.max_input_age_ns
PERIOD_NS = 20 * MS


def controller_with(policy: Policy, contract: PolicyContract = SMALL) -> Controller:
    return Controller(policy, contract, RetinaSense(contract.retina), "hash")


def decide(
    *batches: tuple[Message, ...], policy: Policy | None = None, contract: PolicyContract = SMALL
) -> list[Decision]:
    """One tick a batch, at the moment that its last message came, or a period after the last."""
    controller, state, now_ns, decisions = (
        controller_with(policy or ScriptedPolicy(), contract),
        State(),
        0,
        [],
    )
    for slot, batch in enumerate(batches):
        now_ns = batch[-1].received_ns if batch else now_ns + PERIOD_NS
        state, decision = controller.step(state, Inputs(batch, slot), now_ns)
        decisions.append(decision)
    return decisions


def good(count: int, first: int = 0) -> list[tuple[Message, ...]]:
    return [(retina_message(first + i, (first + i) * PERIOD_NS),) for i in range(count)]


def verdicts(decisions: list[Decision]) -> list[str]:
    return [decision.verdict.name for decision in decisions]


def with_(message: Message, **changes: object) -> Message:
    return dataclasses.replace(message, **changes)  # type: ignore[arg-type]


def test_without_input_the_body_is_told_to_stop():
    (decision,) = decide(())
    assert decision.verdict is Verdict.NO_INPUT
    assert decision.command.is_safe
    assert (decision.command.linear_mps, decision.command.action) == (0.0, SAFE_ACTION)
    assert decision.input is None


def test_it_drives_after_enough_good_inputs_in_a_row():
    names = verdicts(decide(*good(3 + 1)))
    assert names == ["RECOVERING"] * (3 - 1) + ["OK", "OK"]


def test_many_inputs_in_one_tick_count_each_and_the_newest_is_used():
    batch = tuple(message for (message,) in good(5))
    policy = ScriptedPolicy()
    (decision,) = decide(batch, policy=policy)
    assert decision.verdict is Verdict.OK
    assert decision.inputs == 5
    assert decision.input is not None
    assert decision.input.sequence == 4


def test_a_drive_command_is_the_winning_action_with_the_echo_of_its_input():
    decision = decide(*good(4))[-1]
    command = decision.command
    assert decision.action == 1  # ScriptedPolicy: left has the largest value
    assert (command.linear_mps, command.lateral_mps) == (1.0, 1.0)
    assert (command.source_sequence, command.source_time_ns) == (3, 3 * PERIOD_NS)
    assert command.valid_for_ns == LIMIT_NS
    assert decision.q_values == pytest.approx((0.1, 0.9, 0.2))


def test_an_input_is_stale_just_after_the_limit_and_not_at_it():
    controller, state = controller_with(ScriptedPolicy()), State()
    for batch in good(3):
        state, _ = controller.step(state, Inputs(batch, 0), batch[0].received_ns)
    last_ns = 2 * PERIOD_NS
    _, at_limit = controller.step(state, Inputs((), 1), last_ns + LIMIT_NS)
    _, beyond = controller.step(state, Inputs((), 1), last_ns + LIMIT_NS + 1)
    assert at_limit.verdict is Verdict.OK
    assert beyond.verdict is Verdict.STALE_INPUT
    assert beyond.command.is_safe
    assert beyond.input is not None
    assert beyond.input.age_ns == LIMIT_NS + 1


def test_after_staleness_good_inputs_must_come_in_a_row_again():
    silence: list[tuple[Message, ...]] = [()] * 6
    names = verdicts(decide(*good(3), *silence, *good(3, first=20)))
    assert names[2:] == ["OK"] * 6 + ["STALE_INPUT"] + ["RECOVERING"] * 2 + ["OK"]


def bad_messages() -> dict[str, Message]:
    fine = retina_message(9, 9 * PERIOD_NS)
    wrong_size = retina_message(9, 9 * PERIOD_NS, spec=RetinaSpec(rays=5))
    colour = retina_message(9, 9 * PERIOD_NS, spec=RetinaSpec(rays=4, channels=3))
    return {
        "not protobuf": with_(fine, payload=b"\xff\xff\xff"),
        "empty": with_(fine, payload=b""),
        "truncated": with_(fine, payload=fine.payload[:-2]),
        "huge": with_(fine, payload=bytes((1 << 20) + 1)),
        "wrong encoding": with_(fine, encoding="application/protobuf;foxglove.LaserScan"),
        "no encoding": with_(fine, encoding="zenoh/bytes"),
        "no attachment": with_(fine, attachment=b""),
        "short attachment": with_(fine, attachment=fine.attachment[:-1]),
        "long attachment": with_(fine, attachment=fine.attachment + b"x"),
        "negative numbers": with_(fine, attachment=b"\xff" * 16 + fine.attachment[16:]),
        "wrong number of rays": wrong_size,
        "wrong channels": colour,
    }


@pytest.mark.parametrize("name", list(bad_messages()))
def test_a_bad_retina_gives_a_verdict_and_the_safe_command(name: str):
    decisions = decide(*good(4), (bad_messages()[name],))
    assert decisions[-1].verdict is Verdict.INVALID_INPUT
    assert decisions[-1].command.is_safe
    assert decisions[-1].reason
    assert "\n" not in decisions[-1].reason


def test_after_a_bad_retina_good_ones_must_come_in_a_row_again():
    bad = (bad_messages()["truncated"],)
    names = verdicts(decide(*good(4), bad, (), *good(3, first=10)))
    assert names[4:] == ["INVALID_INPUT", "INVALID_INPUT", "RECOVERING", "RECOVERING", "OK"]


def test_a_frozen_sender_goes_stale_though_it_keeps_sending():
    frozen = retina_message(3, 3 * PERIOD_NS)
    repeats = [(with_(frozen, received_ns=frozen.received_ns + i * PERIOD_NS),) for i in range(9)]
    names = verdicts(decide(*good(3), *repeats))
    assert names[3:9] == ["OK"] * 6
    assert set(names[9:]) <= {"STALE_INPUT", "RECOVERING"}


def test_a_reordered_message_is_not_taken_for_the_newest():
    late = with_(retina_message(2, 2 * PERIOD_NS, value=99), received_ns=4 * PERIOD_NS)
    policy = ScriptedPolicy()
    decisions = decide(*good(4), (late,), policy=policy)
    assert decisions[-1].input is not None
    assert decisions[-1].input.sequence == 3
    assert set(policy.given[-1].ravel().tolist()) == {7}


def test_a_sender_that_restarts_is_heard_again_by_its_later_time():
    restarted = [(retina_message(i, (10 + i) * PERIOD_NS),) for i in range(2)]
    decisions = decide(*good(5), *restarted)
    assert [d.input.sequence for d in decisions[5:] if d.input] == [0, 1]
    assert verdicts(decisions)[5:] == ["OK", "OK"]


@pytest.mark.parametrize(
    "policy",
    [
        FailingPolicy(),
        ScriptedPolicy((math.nan, 0.0, 0.0)),
        ScriptedPolicy((math.inf, 0.0, 0.0)),
        ScriptedPolicy((0.0, 0.0, 0.0, 5.0)),  # an action that the contract does not have
    ],
)
def test_a_policy_that_fails_gives_a_verdict_and_the_safe_command(policy: Policy):
    decision = decide(*good(4), policy=policy)[-1]
    assert decision.verdict is Verdict.POLICY_FAULT
    assert decision.command.is_safe
    assert decision.retina == bytes([7] * 4)


def test_asked_to_stop_it_stops_whatever_the_input():
    controller, state = controller_with(ScriptedPolicy()), State()
    for batch in good(4):
        state, _ = controller.step(state, Inputs(batch, 0), batch[0].received_ns)
    _, last = controller.step(state, Inputs((), 9, stop=True), 4 * PERIOD_NS)
    assert last.verdict is Verdict.STOPPED
    assert last.command.is_safe


def test_the_stack_of_frames_begins_as_copies_and_advances_once_an_accepted_input():
    contract = PolicyContract(retina=dataclasses.replace(SPEC, frames=3))
    policy = ScriptedPolicy()
    batches = [(retina_message(i, i * PERIOD_NS, value=10 + i),) for i in range(4)]
    decide(*batches[:3], (), batches[3], policy=policy, contract=contract)
    stacks = [given[0, :, 0, 0, 0].tolist() for given in policy.given]
    assert stacks == [[10, 11, 12], [10, 11, 12], [11, 12, 13]]


def test_index_counts_ticks_and_slot_is_the_pacer_s():
    controller, state = controller_with(ScriptedPolicy()), State()
    seen = []
    for slot in (1, 2, 5):
        state, decision = controller.step(state, Inputs((), slot), slot * PERIOD_NS)
        seen.append((decision.index, decision.slot, decision.command.sequence))
    assert seen == [(0, 1, 0), (1, 2, 1), (2, 5, 2)]


MESSAGES = st.one_of(
    st.builds(retina_message, st.integers(0, 20), st.just(0), value=st.integers(0, 255)),
    st.builds(
        Message,
        st.text(max_size=5),
        st.binary(max_size=40),
        st.sampled_from(["application/protobuf;foxglove.RawImage", "x"]),
        st.one_of(st.binary(max_size=40), st.just(retina_message(1, 1).attachment)),
        st.just(0),
    ),
)


@given(st.lists(st.lists(MESSAGES, max_size=4), max_size=8), st.lists(st.integers(0, 200 * MS)))
def test_whatever_arrives_the_step_is_pure_and_never_raises(
    batches: list[list[Message]], gaps_ns: list[int]
):
    def run() -> list[Decision]:
        controller, state, now_ns, decisions = controller_with(ScriptedPolicy()), State(), 0, []
        for slot, batch in enumerate(batches):
            now_ns += gaps_ns[slot % len(gaps_ns)] if gaps_ns else PERIOD_NS
            arrived = tuple(with_(message, received_ns=now_ns) for message in batch)
            state, decision = controller.step(state, Inputs(arrived, slot), now_ns)
            decisions.append(decision)
        return decisions

    decisions = run()
    assert decisions == run()
    for decision in decisions:
        assert decision.command.is_safe == (decision.verdict is not Verdict.OK)
        assert bool(decision.q_values) == (decision.verdict is Verdict.OK)
        assert np.isfinite(decision.command.linear_mps)
