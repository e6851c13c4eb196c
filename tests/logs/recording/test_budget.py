"""What strangers can make a log hold, counted by hand; and that what is cut decides alike."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.container.rejected import Intake, rejected_message
from reflexarc_logs.recording.budget import (
    BURST_BYTES,
    CONTROLS_BYTES_PER_S,
    ENTRY_BYTES,
    NOISE_BYTES_PER_S,
    OTHERS_BYTES_PER_S,
    Budgets,
    ByteBudget,
    shortened,
)
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller_state import BoundBody, RangeState, State
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    UndecodableError,
    pack_stamp,
    protobuf_encoding,
)
from reflexarc_runtime.messages_pb2 import Rejected, Stop, Tick
from reflexarc_runtime.sensing.senses import RetinaSense
from support.recordings import retina_at

GOOD = retina_at(1, np.zeros((1, 16, 1), np.uint8))
BODY, STRANGER = b"the robot's body", b"a stranger, 16 b"
NOISE = np.random.default_rng(0).bytes(60_000)
"""No protobuf."""
SENSE = RetinaSense(RetinaSpec(rays=16))


def message(topic: str, payload: bytes, sender: bytes, schema: str) -> Message:
    stamp = pack_stamp(Stamp(1, 1, sender))
    return Message(f"robot0/{topic}", payload, protobuf_encoding(schema), stamp, 1)


def scene(size: int, sender: bytes = STRANGER) -> Message:
    """A well-formed scene of which nothing is known but its size: an unknown field."""
    return message("scene", _unknown_field(size), sender, "foxglove.SceneUpdate")


def retina(size: int, sender: bytes) -> Message:
    return message("retina", _unknown_field(size), sender, "foxglove.RawImage")


def _unknown_field(size: int) -> bytes:
    length = bytes([0x80 | size & 0x7F, 0x80 | size >> 7 & 0x7F, size >> 14])
    return b"\xfa\x3f" + length + bytes(size)  # field 1023, of bytes


def tick(more: bytes = b"") -> Message:
    return message("tick", Tick().SerializeToString() + more, b"the runtime, 16b", "reflexarc.Tick")


def bound_to(body: bytes, ranges: bytes = b"") -> Keyframe:
    """What a loop hands over once a second: to whom it is bound."""
    source = BoundBody(ranges, 0) if ranges else None
    state = State(source=BoundBody(body, 0), ranges=RangeState(source=source))
    return Keyframe(state, 0)


class Written:
    """What of a series of messages is written."""

    def __init__(self, *, of_loop: bool = True) -> None:
        self.intake, self.budgets = Intake("robot0"), Budgets(of_loop=of_loop)
        self.count = self.size = 0

    def put(self, message: Message | Keyframe, now_s: float = 0.0) -> bool:
        entry = self.budgets.granted(self.intake.sort(message), now_s)
        if entry is not None:
            self.count, self.size = self.count + 1, self.size + len(entry.payload)
        return entry is not None


@given(
    st.lists(st.tuples(st.floats(0, 5), st.integers(0, 2000)), max_size=50),
    st.floats(1, 1000),
    st.floats(0, 3000),
)
def test_a_budget_never_grants_more_than_a_burst_and_its_rate(steps, rate, burst):
    budget, now_s, granted = ByteBudget(rate, burst), 0.0, 0
    for pause_s, size in steps:
        now_s += pause_s
        granted += size * budget.affords(size, now_s)
        assert granted <= burst + rate * now_s + 1e-6


def test_an_hour_of_four_hundred_noisy_messages_a_second_is_less_than_two_gigabytes():
    written, seconds = Written(), 30
    noisy = replace(GOOD, payload=NOISE)
    for number in range(400 * seconds):
        assert written.put(noisy, number / 400)
    steady = written.size - BURST_BYTES
    assert steady / seconds * 3600 < 2e9  # whole they were 60 kB * 400 * 3600 = 86 GB
    assert steady / seconds > NOISE_BYTES_PER_S / 2
    assert (written.budgets.missing, written.budgets.beside) == (0, 0)


@pytest.mark.parametrize(
    "noisy",
    [
        replace(GOOD, payload=NOISE),
        replace(GOOD, payload=b"\xff"),
        replace(GOOD, payload=bytes((1 << 20) + 1)),
        replace(GOOD, payload=NOISE, encoding="x" * 256),
        replace(GOOD, payload=NOISE, attachment=b""),
        replace(GOOD, attachment=bytes(66)),
        replace(GOOD, attachment=bytes(67)),
        replace(GOOD, attachment=bytes(1024)),
        replace(GOOD, attachment=pack_stamp(Stamp(-1, -5))),
    ],
)
def test_what_is_cut_is_refused_by_the_sense_in_the_same_words(noisy):
    entry = Intake("robot0").sort(noisy)
    cut = shortened(entry, Rejected.FromString(entry.payload))
    back = rejected_message(Rejected.FromString(cut.payload), noisy.received_ns)
    with pytest.raises(UndecodableError) as before:
        SENSE.decode(noisy)
    with pytest.raises(UndecodableError) as after:
        SENSE.decode(back)
    assert str(before.value) == str(after.value)
    assert len(cut.payload) < 700


def test_what_the_loop_hands_over_is_never_left_out():
    written = Written()
    while written.put(scene(500_000)):
        pass
    assert written.put(tick())
    assert written.put(bound_to(BODY))
    assert written.budgets.beside == 1


@pytest.mark.parametrize("bound", [bound_to(BODY), bound_to(b"another", BODY)])
def test_the_body_that_it_is_bound_to_is_recorded_whole_and_a_stranger_is_not(bound):
    written = Written()
    written.put(bound)
    for _ in range(2 * BURST_BYTES // 500_000):
        assert written.put(retina(500_000, BODY))
    while written.put(retina(500_000, STRANGER)):
        pass
    assert (written.budgets.missing, written.budgets.beside) == (1, 0)
    assert written.put(retina(500_000, BODY))
    assert not written.put(scene(500_000))
    assert (written.budgets.missing, written.budgets.beside) == (1, 1)


def test_a_budget_that_was_spent_fills_again_at_its_rate():
    written = Written()
    while written.put(scene(500_000)):
        pass
    wait_s = (500_000 + ENTRY_BYTES + 100) / OTHERS_BYTES_PER_S
    assert not written.put(scene(500_000), 0.05)
    assert written.put(scene(500_000), wait_s)


def test_noise_pushes_no_stop_out_and_a_broken_stop_is_kept_whole():
    written = Written()
    while written.put(scene(500_000)):
        pass
    for _ in range(2000):
        written.put(replace(GOOD, payload=NOISE))
    stop = message("stop", Stop(reason="fire").SerializeToString(), STRANGER, "reflexarc.Stop")
    broken = replace(stop, attachment=b"")
    entry = written.budgets.granted(written.intake.sort(stop), 0.0)
    assert entry is not None
    assert entry.payload == stop.payload
    entry = written.budgets.granted(written.intake.sort(broken), 0.0)
    assert entry is not None
    assert Rejected.FromString(entry.payload).payload == stop.payload


def test_a_flood_of_stops_is_counted_as_missing():
    written = Written()
    stop = message("stop", b"\x0a\x80\x80\x04" + bytes(1 << 16), STRANGER, "reflexarc.Stop")
    for number in range(2000):
        written.put(stop, number / 400)
    assert written.budgets.missing == 2000 - written.count
    assert written.size <= BURST_BYTES + 5 * CONTROLS_BYTES_PER_S


def test_a_good_message_of_one_sender_too_many_is_kept_whole_or_counted():
    written = Written()
    for number in range(200):
        written.put(retina(500_000, bytes([number] * 15) + b"x"))
    assert written.budgets.missing > 0
    assert written.count + written.budgets.missing == 200


def test_a_listener_takes_no_tick_for_its_own():
    written = Written(of_loop=False)
    for _ in range(200):
        written.put(tick(_unknown_field(500_000)))
    assert written.size <= BURST_BYTES
