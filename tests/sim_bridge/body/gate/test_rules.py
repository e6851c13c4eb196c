"""The gate against a slow account of its rules."""

from collections import Counter
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.messages.controls import encode_own_release
from reflexarc_runtime.messages.topics import ARM, RELEASE, RESET, STOP
from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.gate.gate import Gate
from reflexarc_sim_bridge.body.gate.limits import Motion
from reflexarc_sim_bridge.body.gate.refusal import Refusal
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from support.gates import BODY, MS, ONE, OPERATOR, OTHER, drive, hold, message, safe
from support.slow_gate import Event, SlowGate

SENDERS = {"a": ONE, "b": OTHER, "o": OPERATOR, "?": None}
TOPICS = {"stop": STOP, "reset": RESET, "arm": ARM, "release": RELEASE}
RARE = ["let go", "give back", *TOPICS]
KINDS = ["drive"] * 8 + ["safe"] * 2 + ["look"] * 4 + ["hold"] * 4 + RARE
GROUPS = {
    Refusal.OTHER_SENDER: "not the holder",
    Refusal.RELEASED: "not the holder",
    Refusal.STOPPED: "stopped",
    Refusal.DISARMED: "disarmed",
    Refusal.OTHER_HOLDER: "button",
    Refusal.PRESSED_BEFORE: "button",
}
SPEED = st.sampled_from([0.0, 0.25, 1.0, -1.0, 3.0, float("nan")])


@st.composite
def events(draw: st.DrawFn) -> tuple[Event, ...]:
    found, at_ms = list[Event](), 0
    for _ in range(draw(st.integers(1, 25))):
        at_ms += draw(st.sampled_from([0, 1, 10, 30, 60, 61, 200, 460]))
        event = Event(
            draw(st.sampled_from(KINDS)),  # type: ignore[arg-type]  # strings of that Literal
            at_ms,
            draw(st.sampled_from("aaabbo?")),
            at_ms - draw(st.sampled_from([0, 5, 40, 99, 100, -1])),
            draw(st.sampled_from([100, 100, 50, 0, 10**9])),
            (draw(SPEED), draw(SPEED), draw(SPEED)),
            draw(st.sampled_from([True] * 9 + [False])),
            draw(st.sampled_from([True] * 9 + [False])),
            at_ms - draw(st.sampled_from([0, 40, 100, 300, 1000, -1])),
        )
        found.append(event)
    return (*found, Event("look", at_ms))


def message_of(event: Event) -> Message:
    sender = SENDERS[event.sender]
    if event.kind == "safe":
        said = safe(sender)
    elif event.kind == "drive":
        linear, lateral, angular = event.speeds
        said = drive(
            event.source_ms * MS,
            sender,
            linear,
            event.valid_for_ms * MS,
            BODY if event.is_for_us else OTHER,
            lateral_mps=lateral,
            angular_radps=angular,
        )
    elif event.kind == "give back":
        said = message(RELEASE, encode_own_release("the end"), sender)
    elif event.kind in ("hold", "let go"):
        said = hold(
            event.source_ms * MS,
            event.pressed_ms * MS,
            sender,
            held=event.kind == "hold",
            body=BODY if event.is_for_us else OTHER,
        )
    else:
        said = message(TOPICS[event.kind], sender=sender)
    return said if event.is_in_order else replace(said, encoding="text/plain")


@settings(max_examples=250, deadline=None)
@given(
    events(),
    st.sampled_from([(True, False), (False, False), (False, True)]),
    st.sampled_from([30, 60, 1000]),
    st.sampled_from([(9.0, 9.0, 9.0), (0.5, 1.0, 0.0)]),
)
def test_the_gate_does_what_a_slow_account_of_its_rules_says(
    heard: tuple[Event, ...],
    arming: tuple[bool, bool],
    valid_for_ms: int,
    largest: tuple[float, float, float],
):
    limits = BodyLimits(*largest, valid_for_s=valid_for_ms / 1e3)
    gate = Gate.closed(BODY, GateSettings(0.06, limits, *arming))
    for number, event in enumerate(heard, 1):
        if event.kind != "look":
            gate = gate.hear(message_of(event), event.at_ms * MS)
            continue
        motion, gate = gate.obey(event.at_ms * MS, 0.01)
        slow = SlowGate(heard[:number], 60, valid_for_ms, largest, *arming)
        assert motion == Motion(*map(pytest.approx, slow.does()))
        holder, grants = slow.holders()[-1]
        account = gate.lease
        assert account.lease.holder == (SENDERS[holder] if holder else b"")
        assert account.lease.epoch == grants
        assert bool(account.stopped) is slow.stopped(number)
        assert account.armed is slow.armed(number)
    assert _refused(gate, heard) == +slow.refused()


def _refused(gate: Gate, heard: tuple[Event, ...]) -> Counter[str]:
    """What the gate refused, in the groups of the slow account; operators' messages taken out."""
    counts: Counter[str] = Counter()
    for reason, count in gate.lease.refused:
        if reason not in (Refusal.TOO_FAST, Refusal.NEEDS_BUTTON):
            counts[GROUPS.get(Refusal(reason), "faulty")] += count
    told = [e for e in heard if e.kind in ("reset", "arm", "release", "give back")]
    counts["faulty"] -= sum(not e.is_in_order or e.sender == "?" for e in told)
    for index, event in enumerate(heard):
        in_order = event.is_in_order and event.sender != "?"
        slow = SlowGate(heard[:index], 60, 100, (1.0, 1.0, 1.0), True)
        counts["stopped"] -= event.kind == "arm" and in_order and slow.stopped(index)
    return +counts
