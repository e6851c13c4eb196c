import math
from dataclasses import replace

import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.controls import encode_own_release, encode_stop
from reflexarc_runtime.messages.topics import ARM, COMMAND, RELEASE, RESET, RETINA, STOP
from reflexarc_runtime.messages.wire import NO_SENDER, Message
from reflexarc_sim_bridge.body.gate.account import encode_lease
from reflexarc_sim_bridge.body.gate.gate import Gate
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.gate.refusal import Refusal
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from support.gates import BODY, MS, ONE, OTHER, drive, message, safe

SETTINGS = GateSettings(max_input_age_s=0.1, auto_arm=True)
OPEN = Gate.closed(BODY, SETTINGS)
AHEAD = Motion(1.0)


def after(gate: Gate, *heard: Message, now_ns: int = 0) -> Gate:
    for one in heard:
        gate = gate.hear(one, now_ns)
    return gate


def does(gate: Gate, now_ns: int = 0) -> Motion:
    return gate.obey(now_ns, 0.02)[0]


def test_a_valid_command_of_the_first_sender_is_obeyed():
    gate = after(OPEN, drive(0))
    assert does(gate) == AHEAD
    assert (gate.lease.lease.holder, gate.lease.lease.epoch) == (ONE, 1)
    assert gate.lease.refused == ()


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (drive(0, encoding="text/plain"), Refusal.ENCODING),
        (drive(0, payload=bytes(2 << 20)), Refusal.ENCODING),
        (drive(0, sender=None), Refusal.UNSIGNED),
        (drive(0, sender=NO_SENDER), Refusal.UNSIGNED),
        (drive(0, attachment=b"short"), Refusal.UNSIGNED),
        (drive(0, payload=b"\xff\xff"), Refusal.UNREADABLE),
        (drive(0, linear_mps=math.nan), Refusal.UNREADABLE),
        (drive(0, angular_radps=math.inf), Refusal.UNREADABLE),
        (drive(0, body=b""), Refusal.OTHER_BODY),
        (drive(0, body=b"another body...."), Refusal.OTHER_BODY),
        (drive(1), Refusal.FUTURE),
        (drive(-100 * MS), Refusal.OLD),
        (drive(0, valid_for_ns=0), Refusal.OLD),
        (drive(0, valid_for_ns=-5), Refusal.OLD),
    ],
)
def test_what_is_not_in_order_moves_nothing_takes_no_lease_and_is_counted(
    bad: Message, reason: Refusal
):
    gate = after(OPEN, bad)
    assert does(gate) == STANDSTILL
    assert gate.lease.lease.is_free
    assert gate.lease.refused == ((reason, 1),)


def test_the_command_that_was_to_drive_for_ever_moves_nothing():
    for sender in (None, ONE):
        for_ever = drive(0, sender=sender, valid_for_ns=2**63 - 1, body=b"")
        assert does(after(OPEN, *[for_ever] * 500, now_ns=MS), 2 * MS) == STANDSTILL


def test_a_command_is_obeyed_for_the_shorter_of_its_validity_and_the_body_s():
    short = replace(SETTINGS, limits=BodyLimits(valid_for_s=0.03))
    for settings, asked_ms, end_ms in [(SETTINGS, 50, 50), (short, 50, 30), (short, 20, 20)]:
        gate = after(Gate.closed(BODY, settings), drive(0, valid_for_ns=asked_ms * MS))
        assert does(gate, end_ms * MS - 1) == AHEAD
        assert does(gate, end_ms * MS) == STANDSTILL


def test_a_command_of_a_body_without_a_longest_validity_ends_with_the_lease():
    gate = after(OPEN, drive(0, valid_for_ns=2**63 - 1))
    assert does(gate, 100 * MS) == AHEAD
    assert does(gate, 100 * MS + 1) == STANDSTILL


def test_others_are_ignored_and_counted_safe_commands_too():
    gate = after(OPEN, drive(0), safe(OTHER), drive(0, OTHER, linear_mps=-1.0), now_ns=MS)
    assert does(gate, MS) == AHEAD
    assert gate.lease.refused == ((Refusal.OTHER_SENDER, 2),)


def test_a_safe_command_of_the_holder_stands_whatever_speeds_it_names():
    assert does(after(OPEN, drive(0), safe(linear_mps=5.0))) == STANDSTILL


def test_after_the_silence_of_the_holder_another_one_is_obeyed_and_it_is_not():
    gate = after(OPEN, drive(0))
    assert after(gate, drive(100 * MS, OTHER), now_ns=100 * MS).lease.lease.holder == ONE
    gate = after(gate, drive(101 * MS, OTHER), drive(101 * MS, ONE), now_ns=101 * MS)
    assert (gate.lease.lease.holder, gate.lease.lease.epoch) == (OTHER, 2)
    assert gate.lease.refused == ((Refusal.OTHER_SENDER, 1),)


def test_a_lease_that_nobody_wants_is_free_after_the_silence():
    assert after(OPEN, drive(0)).obey(101 * MS, 0.02)[1].lease.lease.is_free


def test_in_lockstep_nothing_expires():
    gate = after(Gate.closed(BODY, replace(SETTINGS, lockstep=True)), safe())
    assert gate.obey(3600 * 1000 * MS, 0.02)[1].lease.lease.holder == ONE
    released = after(gate, message(RELEASE), drive(0))
    assert released.lease.lease.holder == ONE


def test_a_release_lets_the_other_one_in_although_the_holder_goes_on():
    gate = after(OPEN, drive(0), message(RELEASE))
    assert gate.lease.lease.is_free
    assert does(gate) == STANDSTILL
    gate = after(gate, drive(0), drive(0, OTHER), drive(0))
    assert gate.lease.lease.holder == OTHER
    assert gate.lease.refused == ((Refusal.RELEASED, 1), (Refusal.OTHER_SENDER, 1))


def test_who_gave_the_lease_back_gets_it_again_if_nobody_else_came():
    gate = after(OPEN, drive(0), message(RELEASE))
    assert after(gate, drive(100 * MS), now_ns=100 * MS).lease.lease.is_free
    assert after(gate, drive(101 * MS), now_ns=101 * MS).lease.lease.epoch == 2


def test_whoever_gives_its_own_lease_back_gives_nobody_else_s():
    gate = after(OPEN, drive(0))
    own = encode_own_release("the end of the run")
    assert does(after(gate, message(RELEASE, own, OTHER))) == AHEAD
    assert after(gate, message(RELEASE, own, OTHER)).lease.lease.holder == ONE
    given = after(gate, message(RELEASE, own, ONE))
    assert does(given) == STANDSTILL
    assert does(after(given, drive(0, OTHER))) == AHEAD


def test_the_release_of_a_lease_that_silence_had_ended_keeps_nobody_waiting():
    gate = after(after(OPEN, drive(0)), message(RELEASE), drive(101 * MS), now_ns=101 * MS)
    assert (gate.lease.lease.holder, gate.lease.lease.epoch) == (ONE, 2)


@pytest.mark.parametrize("garbled", [False, True])
@pytest.mark.parametrize("sender", [ONE, OTHER, NO_SENDER, None])
def test_a_stop_of_anybody_stops_until_a_reset(sender: bytes | None, garbled: bool):
    stop = message(STOP, b"\xff" if garbled else encode_stop("fire"), sender, encoding="any")
    gate = after(OPEN, drive(0), stop, drive(0))
    assert does(gate) == STANDSTILL
    assert gate.lease.stopped == ("a stop without a reason" if garbled else "fire")
    assert does(after(gate, message(ARM), drive(0))) == STANDSTILL
    assert does(after(gate, message(RESET))) == STANDSTILL
    assert does(after(gate, message(RESET), drive(0))) == AHEAD


def test_the_reason_of_the_first_stop_is_kept():
    gate = after(OPEN, message(STOP, encode_stop("fire")), message(STOP, encode_stop("flood")))
    assert gate.lease.stopped == "fire"


def test_a_disarmed_body_stands_and_a_reset_disarms():
    gate = after(Gate.closed(BODY, replace(SETTINGS, auto_arm=False)), drive(0))
    assert does(gate) == STANDSTILL
    assert gate.lease.refused == ((Refusal.DISARMED, 1),)
    gate = after(gate, message(ARM))
    assert does(gate) == STANDSTILL  # what it heard before it was armed moves nothing
    gate = after(gate, drive(0))
    assert does(gate) == AHEAD
    assert does(after(gate, message(RESET), drive(0))) == STANDSTILL


def test_a_stopped_or_disarmed_body_stands_even_where_its_safe_motion_moves():
    rush = Gate.closed(BODY, replace(SETTINGS, safe=Motion(3.0)))
    assert does(rush) == Motion(3.0)
    assert does(after(rush, message(STOP))) == STANDSTILL
    assert does(replace(rush, allowed=False)) == STANDSTILL


def test_a_stop_before_the_end_of_a_body_holds_after_its_start():
    assert does(after(Gate.closed(BODY, SETTINGS, stopped="fire"), drive(0))) == STANDSTILL


@pytest.mark.parametrize("topic", [ARM, RESET, RELEASE])
@pytest.mark.parametrize(
    "bad", [{"encoding": "text/plain"}, {"sender": None}, {"payload": b"\xff"}]
)
def test_only_a_stop_is_heard_out_of_order(topic, bad):
    gate = after(OPEN, drive(0), message(STOP))
    refused = after(gate, message(topic, **bad))
    assert replace(refused, refusals=()) == gate
    assert sum(count for _, count in refused.lease.refused) == 1


def test_other_topics_change_nothing():
    assert after(OPEN, message(RETINA)) is OPEN


def test_too_fast_a_command_is_slowed_in_its_direction_and_counted():
    limits = BodyLimits(linear_mps=1.0, lateral_mps=2.0, angular_radps=1.0)
    gate = Gate.closed(BODY, replace(SETTINGS, limits=limits))
    gate = after(gate, drive(0, linear_mps=-4.0, lateral_mps=2.0, angular_radps=1.0))
    assert does(gate) == Motion(-1.0, 0.5, 0.25)
    assert gate.lease.refused == ((Refusal.TOO_FAST, 1),)


def test_a_body_of_another_name_obeys_no_echo_of_the_former_one():
    gate = after(OPEN, drive(0)).renamed(OTHER)
    assert does(gate) == STANDSTILL
    assert does(after(gate, drive(0))) == STANDSTILL
    assert does(after(gate, drive(0, body=OTHER))) == AHEAD
    assert gate.renamed(OTHER) is gate


def test_the_lease_says_whom_it_obeys_and_what_it_refused():
    gate = after(OPEN, drive(0), safe(OTHER)).obey(0, 0.02)[1]
    said = pb.Lease.FromString(encode_lease(gate.lease))
    assert (said.holder, said.epoch, said.armed, said.stopped) == (ONE, 1, True, "")
    assert said.state == "driving"
    assert dict(said.refused) == {Refusal.OTHER_SENDER: 1}


@pytest.mark.parametrize(
    ("gate", "state"),
    [
        (OPEN, "waiting for a command"),
        (after(OPEN, safe()), "standing"),
        (replace(OPEN, allowed=False), "waiting for an arm"),
        (after(OPEN, message(STOP)), "stopped: waiting for a reset"),
    ],
)
def test_the_lease_says_in_words_what_the_body_does(gate: Gate, state: str):
    assert gate.lease.state == state


def test_a_silence_that_is_none_is_refused():
    for age_s in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(UsageError):
            GateSettings(max_input_age_s=age_s)


def test_a_command_topic_of_any_robot_is_a_command():
    assert after(OPEN, drive(0, key=COMMAND.key("rover"))).lease.lease.holder == ONE
