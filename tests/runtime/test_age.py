"""The age of an input counts what it waited before it arrived; frozen pictures are refused."""

from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.keyframe import decode_state, encode_state
from reflexarc_runtime.messages.codec import decision_to_protobuf
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp
from reflexarc_runtime.messages_pb2 import Keyframe
from reflexarc_runtime.rules import CURRENT_RULES, RULES, ControllerRules
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, ScriptedPolicy
from support.sensing import MS, retina_message

PERIOD_MS = 20


def driven(
    messages: list[Message],
    *,
    rules: ControllerRules = CURRENT_RULES,
    senses: SenseSettings | None = None,
    through_keyframes: bool = False,
) -> list[Decision]:
    """One tick a message, as it arrives."""
    sense = RetinaSense(SMALL.retina, senses or SenseSettings(allow_unstated_eye=True))
    controller = Controller(ScriptedPolicy(), SMALL, sense, "hash", rules)
    state, decisions = State(), []
    for slot, message in enumerate(messages):
        inputs = Inputs((message,), slot)
        state, decision = controller.step(state, inputs, message.received_ns)
        decisions.append(decision)
        if through_keyframes:
            state = decode_state(Keyframe.FromString(encode_state(state, "hash")), SMALL)
    return decisions


def late(*delays_ms: int, first: int = 0, clock_ms: int = 7_000) -> list[Message]:
    """Retinas every 20 ms on the sender's clock, each so late."""
    return [
        retina_message(
            number,
            (PERIOD_MS * number + delay_ms) * MS,
            source_ns=(clock_ms + PERIOD_MS * number) * MS,
        )
        for number, delay_ms in enumerate(delays_ms, first)
    ]


def test_a_queue_of_two_seconds_is_stale_and_the_reason_says_so():
    decisions = driven(late(*[3] * 5, *[2003] * 5))
    assert [d.verdict for d in decisions[3:]] == [Verdict.OK] * 2 + [Verdict.STALE_INPUT] * 5
    last = decisions[-1]
    assert last.reason == "2.0 s behind its sender's best: a backlog"
    assert last.input is not None
    assert last.input.age_ns == 2000 * MS
    assert last.command.is_safe


def test_after_a_queue_good_inputs_must_come_in_a_row_again():
    names = [d.verdict.name for d in driven(late(*[3] * 5, *[2003] * 5, *[3] * 4))]
    assert names[-4:] == ["RECOVERING", "RECOVERING", "OK", "OK"]


@pytest.mark.parametrize("version", [1, 2, 3])
def test_under_the_rules_of_before_age_counts_from_the_arrival(version: int):
    decisions = driven(late(*[3] * 5, *[2003] * 5), rules=RULES[version])
    assert {d.verdict for d in decisions[2:]} == {Verdict.OK}
    assert {d.input.age_ns for d in decisions if d.input} == {0}


@settings(max_examples=60, deadline=None)
@given(st.lists(st.sampled_from([0, 3, 60, 101, 500]), min_size=4, max_size=40))
def test_a_keyframe_keeps_how_late_they_are(delays_ms: list[int]):
    messages = late(*delays_ms)
    assert driven(messages, through_keyframes=True) == driven(messages)


def test_another_body_has_another_clock():
    mine = late(*[3] * 5)
    other = b"another body".ljust(16)
    theirs = [
        replace(m, attachment=m.attachment[:-16] + other)
        for m in late(*[3] * 4, first=40, clock_ms=1_000_000_000)
    ]
    names = [d.verdict.name for d in driven(mine + theirs)]
    assert names[-2:] == ["OK", "OK"]
    back = [
        replace(m, attachment=m.attachment[:-16] + other)
        for m in late(*[3] * 4, first=40, clock_ms=1)
    ]
    assert [d.verdict.name for d in driven(mine + back)][-2:] == ["OK", "OK"]


@pytest.mark.parametrize("step_ms", [-3000, 3000])
def test_a_sender_whose_clock_steps_is_driven_by_and_no_queue_is_hidden(step_ms: int):
    stepped = late(*[3] * 20, first=5, clock_ms=7_000 + step_ms)
    assert {d.verdict for d in driven(late(*[3] * 5) + stepped)[2:]} == {Verdict.OK}
    queued = late(*[503] * 20, first=5, clock_ms=7_000 + step_ms)
    decisions = driven(late(3, 3, 3, 503, 503) + queued)
    assert {d.verdict for d in decisions[3:]} == {Verdict.STALE_INPUT}


@pytest.mark.parametrize(("stamp_ms", "expected"), [(0, "OK"), (9, "STALE_INPUT")])
def test_stamps_that_never_change_are_old_and_none_at_all_are_no_knowledge(stamp_ms, expected):
    messages = [retina_message(n, n * PERIOD_MS * MS, source_ns=stamp_ms * MS) for n in range(10)]
    assert driven(messages)[-1].verdict.name == expected


def test_pictures_that_overtake_one_another_in_a_queue_stay_old():
    pairs = [number for at in range(5, 45, 2) for number in (at + 1, at)]
    queue = [
        retina_message(
            number,
            (2003 + PERIOD_MS * place) * MS,
            source_ns=(7_000 + PERIOD_MS * number) * MS,
        )
        for place, number in enumerate(pairs, 6)
    ]
    assert Verdict.OK not in {d.verdict for d in driven(late(*[3] * 5) + queue)[5:]}


FROZEN = SenseSettings(frozen_after_s=0.2)


def pictures(*values: int) -> list[Message]:
    return [retina_message(n, n * PERIOD_MS * MS, value=v) for n, v in enumerate(values)]


def test_a_picture_that_never_changes_while_it_drives_is_refused_until_it_does():
    # Told to drive from tick 2 on; at the end of tick 13 it was told so for more than 0.2 s.
    decisions = driven(pictures(*[7] * 20, *[8] * 3), senses=FROZEN, through_keyframes=True)
    names = [d.verdict.name for d in decisions]
    assert names[2:14] == ["OK"] * 12
    assert names[14:20] == ["INVALID_INPUT"] * 6
    assert names[20:] == ["RECOVERING", "RECOVERING", "OK"]
    assert "--frozen-after" in decisions[14].reason


def test_pictures_that_change_now_and_then_are_not_frozen():
    names = {d.verdict for d in driven(pictures(*([7] * 10 + [8] * 10) * 3), senses=FROZEN)[2:]}
    assert names == {Verdict.OK}


def test_a_body_that_is_not_told_to_drive_may_see_the_same_for_ever():
    stop = Message("robot0/stop", b"", "application/protobuf;reflexarc.Stop", b"", 0)
    messages = [stop, *pictures(*[7] * 50)]
    assert {d.verdict for d in driven(messages, senses=FROZEN)} == {Verdict.STOPPED}
    reset = replace(stop, key="robot0/reset", encoding="application/protobuf;reflexarc.Reset")
    names = [d.verdict.name for d in driven([*messages, reset], senses=FROZEN)]
    assert "INVALID_INPUT" not in names


def test_nobody_who_did_not_ask_pays_for_it():
    sense = RetinaSense(SMALL.retina)
    assert sense.decode(retina_message(0, 0)).picture == b""
    assert {d.verdict for d in driven(pictures(*[7] * 50))[2:]} == {Verdict.OK}


@settings(max_examples=200, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 9), st.sampled_from([0, 1, 10**9, 1 << 60, 1 << 61, (1 << 63) - 1])
        ),
        max_size=30,
    )
)
def test_no_stamps_whatever_raise_here_or_in_a_keyframe(stamps: list[tuple[int, int]]):
    messages = []
    for number, (sequence, stamp_ns) in enumerate(stamps):
        at_ns = (7_000 + number * PERIOD_MS) * MS
        good = retina_message(sequence, at_ns, source_ns=0)
        stamp = pack_stamp(Stamp(sequence, stamp_ns))
        messages += [replace(good, attachment=stamp), replace(good, payload=b"\xff")]
    for decision in driven(messages, through_keyframes=True):
        decision_to_protobuf(decision)
