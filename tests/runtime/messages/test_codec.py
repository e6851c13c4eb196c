import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import (
    Decision,
    Input,
    Timing,
    Verdict,
    drive_command,
    safe_command,
)
from reflexarc_runtime.messages.codec import (
    SCHEMAS,
    decode_command,
    encode_command,
    encode_tick,
    timestamp,
)
from reflexarc_runtime.messages.topics import TOPICS, topic_of
from reflexarc_runtime.messages.wire import (
    MAX_SEQUENCE,
    Stamp,
    UndecodableError,
    at_source_time,
    pack_stamp,
    unpack_stamp,
)
from support.sensing import MS, retina_message

ECHO = Input(9, 123, 456, 789)
LEFT = Action("left", 1.0, 0.5)


def test_verdicts_have_the_same_numbers_here_and_on_the_wire():
    named = {name: number for name, number in pb.Verdict.items() if number}
    assert named == {verdict.name: verdict.value for verdict in Verdict}


def test_every_topic_has_a_message_and_every_message_a_topic():
    assert {topic.schema for topic in TOPICS} == set(SCHEMAS)


def test_a_key_leads_to_its_topic_whatever_the_robot():
    assert all(topic_of(topic.key("rover-7")) is topic for topic in TOPICS)
    assert topic_of("robot0/unheard-of") is None


@given(st.integers(0, MAX_SEQUENCE), st.integers(0, 2**63 - 1))
def test_a_stamp_survives_the_wire(sequence: int, time_ns: int):
    assert unpack_stamp(pack_stamp(Stamp(sequence, time_ns))) == Stamp(sequence, time_ns)


def test_the_attachment_has_the_layout_of_rmw_zenoh():
    """sequence int64, time int64, then a length and 16 bytes: little-endian, by hand."""
    assert pack_stamp(Stamp(1, 258)) == bytes(
        [1, 0, 0, 0, 0, 0, 0, 0, 2, 1, 0, 0, 0, 0, 0, 0, 16, *([0] * 16)]
    )


@given(st.binary(max_size=60))
def test_any_bytes_are_a_stamp_or_are_refused(attachment: bytes):
    try:
        stamp = unpack_stamp(attachment)
    except UndecodableError:
        return
    assert 0 <= stamp.sequence <= MAX_SEQUENCE
    assert stamp.time_ns >= 0


def test_in_lockstep_a_message_arrives_when_it_was_sent():
    message = retina_message(1, received_ns=5, source_ns=40)
    assert at_source_time(message).received_ns == 40
    assert at_source_time(message, earliest_ns=50).received_ns == 50


@pytest.mark.parametrize(
    "command",
    [
        drive_command(3, 1, LEFT, ECHO, 100 * MS),
        drive_command(0, 0, LEFT, Input(0, 0, 0, 0), 1),
        safe_command(4, Verdict.STALE_INPUT, Action("stop", 0.0, 0.0)),
    ],
)
def test_a_command_survives_the_wire(command: object):
    assert decode_command(encode_command(command)) == command  # type: ignore[arg-type]


@pytest.mark.parametrize("speed", [math.nan, math.inf, -math.inf])
def test_a_command_of_no_finite_speed_is_none(speed: float):
    command = drive_command(3, 1, LEFT, ECHO, 100)
    assert decode_command(encode_command(replace(command, lateral_mps=speed))) is None


@pytest.mark.parametrize("payload", [b"", b"\xff", b"\x18\x63"])
def test_bytes_that_are_no_command_are_none(payload: bytes):
    assert decode_command(payload) is None


def test_a_tick_holds_every_field_of_its_decision():
    decision = Decision(
        3,
        5,
        77,
        2,
        ECHO,
        b"\x01\x02",
        (0.5, -0.25, math.nan),
        2,
        1,
        Verdict.OK,
        "why",
        drive_command(3, 1, LEFT, ECHO, 100),
        "abc",
        (0.5, 1.5),
    )
    tick = pb.Tick.FromString(encode_tick(decision, Timing(70, 76, 1, 2499, 2500, 4)))
    said = tick.decision
    assert (said.index, said.slot, said.now_ns, said.inputs) == (3, 5, 77, 2)
    assert (said.input.sequence, said.input.source_time_ns) == (9, 123)
    assert (said.input.received_ns, said.input.age_ns) == (456, 789)
    assert (said.winner, list(said.state)) == (2, [0.5, 1.5])
    assert (said.retina, said.action, said.verdict) == (b"\x01\x02", 1, pb.OK)
    assert list(said.q_values)[:2] == [0.5, -0.25]
    assert math.isnan(said.q_values[2])
    assert (said.reason, said.policy_hash) == ("why", "abc")
    assert (said.command.linear_mps, said.command.lateral_mps) == (1.0, 0.5)
    timing = tick.timing
    assert (timing.lateness_ns, timing.receive_ns) == (6, 1)
    assert (timing.decide_ns, timing.publish_ns, timing.record_ns) == (2000, 3000, 0)
    wake_ns = said.now_ns - timing.receive_ns  # neither it nor the deadline is said again
    assert (wake_ns, wake_ns - timing.lateness_ns) == (76, 70)
    assert (timing.deadline_ns, timing.wake_ns) == (0, 0)


def test_a_time_stamp_is_seconds_and_nanoseconds():
    stamp = timestamp(3_000_000_007)
    assert (stamp.seconds, stamp.nanos) == (3, 7)
