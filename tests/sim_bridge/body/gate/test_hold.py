from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.topics import ARM, RESET, STOP
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.account import encode_lease
from reflexarc_sim_bridge.body.gate.gate import Gate
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.gate.refusal import Refusal
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from support.gates import BODY, MS, ONE, OPERATOR, OTHER, drive, hold, message

NEEDED = Gate.closed(BODY, GateSettings(max_input_age_s=9.0, hold_to_run=True))
DISARMED = Gate.closed(BODY, GateSettings(max_input_age_s=9.0))
FOR_LONG = {"valid_for_ns": 10**12}
FRESH_MS = 500
"""As the documentation says."""


def after(gate: Gate, *heard: tuple[int, Message]) -> Gate:
    for at_ms, one in heard:
        gate = gate.hear(one, at_ms * MS)
    return gate


def rolls(gate: Gate, at_ms: int) -> bool:
    return gate.obey(at_ms * MS, 0.02)[0] != STANDSTILL


def refusals(gate: Gate) -> dict[str, int]:
    return dict(gate.lease.refused)


@pytest.mark.parametrize("gate", [NEEDED, DISARMED])
def test_a_held_button_lets_a_body_drive_until_it_is_too_old(gate: Gate):
    held = after(gate, (100, hold(100 * MS, 100 * MS)), (100, drive(100 * MS, **FOR_LONG)))
    assert held.obey(100 * MS, 0.02)[0] == Motion(1.0)
    assert rolls(held, 100 + FRESH_MS - 1)
    assert not rolls(held, 100 + FRESH_MS)


def test_what_counts_is_the_time_that_it_repeats_and_not_that_of_its_arrival():
    late = after(NEEDED, (450, hold(0)), (450, drive(450 * MS, **FOR_LONG)))
    assert rolls(late, 499)
    assert not rolls(late, 500)
    assert refusals(after(NEEDED, (500, hold(0)))) == {Refusal.OLD: 1}


def test_a_button_that_is_let_go_stops_at_once():
    held = after(NEEDED, (0, hold(0)), (0, drive(0, **FOR_LONG)))
    assert not rolls(after(held, (1, hold(0, held=False))), 1)


def test_what_was_wanted_before_a_press_moves_nothing_after_it():
    gate = after(DISARMED, (0, hold(0)), (0, drive(0, **FOR_LONG)), (1, hold(0, held=False)))
    again = after(gate, (2, hold(2 * MS, 2 * MS)))
    assert not rolls(again, 2)
    assert rolls(after(again, (3, drive(3 * MS, **FOR_LONG))), 3)


def test_a_press_that_was_lost_is_not_taken_up_again_and_a_new_one_is():
    lost = after(NEEDED, (0, hold(0))).obey(600 * MS, 0.02)[1]
    burst = after(lost, *[(600, hold(source_ms * MS)) for source_ms in range(0, 601, 50)])
    assert not burst.armed
    assert refusals(burst) == {Refusal.OLD: 3, Refusal.PRESSED_BEFORE: 10}
    assert after(burst, (650, hold(650 * MS, 610 * MS))).armed


@pytest.mark.parametrize("kind", [STOP, RESET])
def test_a_stop_and_a_reset_end_a_press_and_a_new_one_is_needed(kind):
    gate = after(NEEDED, (0, hold(0)), (10, message(kind)), (20, message(RESET)))
    assert not after(gate, (30, hold(30 * MS, 0))).armed
    assert after(gate, (30, hold(30 * MS, 25 * MS))).armed


def test_a_stopped_body_is_not_armed_by_a_button():
    gate = after(NEEDED, (0, message(STOP)), (10, hold(10 * MS, 10 * MS)))
    assert not gate.armed
    assert refusals(gate) == {Refusal.STOPPED: 1}


def test_an_arm_does_not_do_where_a_button_is_needed():
    gate = after(NEEDED, (0, message(ARM)))
    assert not gate.armed
    assert refusals(gate) == {Refusal.NEEDS_BUTTON: 1}
    assert gate.lease.state == "waiting for a held button"


def test_a_body_that_was_armed_stays_armed_when_a_button_is_let_go():
    gate = after(DISARMED, (0, message(ARM)), (0, hold(0)), (1, hold(0, held=False)))
    assert gate.armed
    assert after(DISARMED, (0, hold(0)), (0, message(ARM)), (0, hold(0, held=False))).armed


def test_one_holds_it_and_what_another_one_says_changes_nothing():
    gate = after(NEEDED, (0, hold(0)), (1, hold(1 * MS, 0, ONE)), (2, hold(0, 0, ONE, held=False)))
    assert gate.lease.held_by == OPERATOR
    assert refusals(gate) == {Refusal.OTHER_HOLDER: 2}
    # Who pressed while another one held it has to press anew.
    free = after(gate, (3, hold(0, held=False)))
    assert not after(free, (4, hold(4 * MS, 1 * MS, ONE))).armed
    assert after(free, (4, hold(4 * MS, 4 * MS, ONE))).lease.held_by == ONE


@pytest.mark.parametrize(
    ("bad", "reason"),
    [
        (hold(0, encoding="text/plain"), Refusal.ENCODING),
        (hold(0, sender=None), Refusal.UNSIGNED),
        (replace(hold(0), payload=b"\xff"), Refusal.UNREADABLE),
        (hold(0, body=OTHER), Refusal.OTHER_BODY),
        (hold(0, body=b""), Refusal.OTHER_BODY),
        (hold(1001 * MS), Refusal.FUTURE),
        (hold(1000 * MS, 1001 * MS), Refusal.FUTURE),
        (hold(500 * MS), Refusal.OLD),
        (replace(hold(0), payload=b""), Refusal.OTHER_BODY),
    ],
)
def test_what_is_not_in_order_arms_nothing_and_is_counted(bad: Message, reason: Refusal):
    gate = after(NEEDED, (1000, bad))
    assert not gate.armed
    assert refusals(gate) == {reason: 1}


def test_a_body_of_another_name_feels_no_button_of_the_former_one():
    assert not after(NEEDED, (0, hold(0))).renamed(OTHER).armed


def test_the_lease_says_who_holds_the_button_and_what_to_repeat():
    said = pb.Lease.FromString(encode_lease(after(NEEDED, (0, hold(0))).lease))
    assert (said.body, said.held_by, said.hold_to_run, said.armed) == (BODY, OPERATOR, True, True)


@given(st.lists(st.tuples(st.integers(0, 300), st.integers(0, 400)), min_size=1, max_size=30))
def test_whoever_is_heard_often_enough_is_never_let_go(gaps_and_ages: list[tuple[int, int]]):
    """Each message repeats so recent a time that the next one comes before it is too old."""
    gate, at_ms, due_ms = after(NEEDED, (0, hold(0))), 0, FRESH_MS
    for gap_ms, age_ms in gaps_and_ages:
        at_ms = min(at_ms + gap_ms, due_ms - 1)
        gate = after(gate, (at_ms, hold(max(0, at_ms - age_ms) * MS)))
        due_ms = max(due_ms, max(0, at_ms - age_ms) + FRESH_MS)
        assert gate.armed


@given(
    st.lists(
        st.tuples(
            st.integers(0, 700),
            st.sampled_from([ONE, OTHER]),
            st.booleans(),
            st.integers(-50, 900),
            st.integers(-50, 900),
        ),
        max_size=20,
    ),
    st.integers(0, 700),
)
def test_armed_only_by_a_recent_echo_of_a_press_that_nothing_has_ended(
    said: list[tuple[int, bytes, bool, int, int]], wait_ms: int
):
    gate, at_ms, heard = NEEDED, 0, []
    for gap_ms, sender, held, source_age_ms, pressed_age_ms in said:
        at_ms += gap_ms
        source_ms, pressed_ms = at_ms - source_age_ms, at_ms - pressed_age_ms
        one = hold(source_ms * MS, pressed_ms * MS, sender, held=held)
        gate = after(gate, (at_ms, one))
        heard.append((at_ms, sender, held, source_ms, pressed_ms))
    now_ms = at_ms + wait_ms
    gate = gate.obey(now_ms * MS, 0.0)[1]
    reasons = [
        message
        for index, message in enumerate(heard)
        if message[2]
        and message[1] == gate.lease.held_by
        and message[3] <= message[0]
        and now_ms - message[3] < FRESH_MS
        and not [m for m in heard[index:] if m[1] == message[1] and not m[2]]
    ]
    assert not gate.armed or reasons


@pytest.mark.parametrize("contrary", [{"auto_arm": True}, {"lockstep": True}])
def test_settings_that_contradict_a_button_are_refused(contrary):
    with pytest.raises(UsageError):
        GateSettings(max_input_age_s=0.1, hold_to_run=True, **contrary)
