import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    UndecodableError,
    UnfitError,
    protobuf_encoding,
    unpack_stamp,
)
from reflexarc_runtime.sensing.senses import RetinaSense
from reflexarc_sim_bridge.body.faults.delayed_sender import DelayedSender
from reflexarc_sim_bridge.body.faults.faulty_stream import FaultyStream, Sending, transform
from reflexarc_sim_bridge.body.faults.random_script import random_script, script_named
from reflexarc_sim_bridge.body.faults.script import (
    KINDS,
    ClockStep,
    Delay,
    Duplication,
    Fault,
    FaultScript,
    Freezing,
    Frozen,
    Jitter,
    Loss,
    Malformation,
    Malformed,
    Reordering,
    SecondSender,
    Silence,
    kind_of,
)
from reflexarc_sim_bridge.body.faults.script_file import parse_script

MS = 1_000_000
SPEC = RetinaSpec(rays=4)
START_NS = 7_000 * MS
STREAM = [
    (
        START_NS + 20 * MS * n,
        encode_retina(np.full(SPEC.shape, n % 251, np.uint8), SPEC, START_NS + 20 * MS * n),
    )
    for n in range(50)
]


def harmed(*faults: Fault, seed: int = 0) -> list[Sending]:
    return list(transform(FaultScript(faults, seed), STREAM))


def stamps(sendings: list[Sending]) -> list[Stamp]:
    return [unpack_stamp(sending.attachment) for sending in sendings]


def numbers(sendings: list[Sending]) -> list[int]:
    return [stamp.sequence for stamp in stamps(sendings)]


def sender(sending: Sending) -> bytes:
    return sending.attachment[17:]


def is_usable(sending: Sending) -> bool:
    """By the runtime's own sense, which knows nothing of faults."""
    message = Message("r/retina", sending.payload, sending.encoding, sending.attachment, 0)
    try:
        RetinaSense(SPEC).decode(message)
    except (UndecodableError, UnfitError):
        return False
    return True


def test_without_faults_every_retina_goes_out_as_it_is_and_at_once():
    sendings = harmed()
    assert [(s.due_ns, s.payload) for s in sendings] == STREAM
    (sender,) = {stamp.sender for stamp in stamps(sendings)}
    assert stamps(sendings) == [Stamp(n, time_ns, sender) for n, (time_ns, _) in enumerate(STREAM)]
    assert all(s.seen_ns == s.due_ns and is_usable(s) for s in sendings)
    assert {s.encoding for s in sendings} == {protobuf_encoding("foxglove.RawImage")}


@given(st.integers(0, 2**32))
@settings(max_examples=30, deadline=None)
def test_equal_scripts_do_equal_harm(seed: int):
    script = random_script(seed)
    assert list(transform(script, STREAM)) == list(transform(script, STREAM))


def test_another_seed_does_other_harm():
    loss = Loss(0.0, 1.0, 0.5)
    assert numbers(harmed(loss, seed=1)) != numbers(harmed(loss, seed=2))


@given(st.integers(0, 2**32))
@settings(max_examples=60, deadline=None)
def test_the_truth_is_what_the_runtimes_own_sense_and_the_stamps_say(seed: int):
    stream = FaultyStream(random_script(seed))
    for n in range(150):
        now_ns = START_NS + 20 * MS * n
        for sending in stream.say(STREAM[n % 50][1], now_ns):
            if sending.seen_ns is None:
                assert not is_usable(sending) or unpack_stamp(sending.attachment).time_ns != now_ns
            else:
                assert is_usable(sending)
                assert unpack_stamp(sending.attachment).time_ns == sending.seen_ns <= now_ns


def test_faults_hold_from_their_begin_to_their_end_and_again_at_every_repetition():
    script = FaultScript((Silence(0.2, 0.1),), repeat_s=0.5)
    sendings = transform(script, STREAM)
    lost = set(range(50)) - {(sending.due_ns - START_NS) // (20 * MS) for sending in sendings}
    assert lost == {10, 11, 12, 13, 14, 35, 36, 37, 38, 39}


def test_a_delay_moves_the_sending_and_not_the_stamp():
    late = harmed(Delay(0.0, 1.0, 0.25))
    assert [s.due_ns for s in late] == [time_ns + 250 * MS for time_ns, _ in STREAM]
    assert [s.seen_ns for s in late] == [time_ns for time_ns, _ in STREAM]


def test_jitter_lets_messages_overtake_each_other_and_loses_none():
    jittered = harmed(Jitter(0.0, 1.0, 0.1))
    assert numbers(jittered) != sorted(numbers(jittered)) == list(range(50))
    assert [s.due_ns for s in jittered] == sorted(s.due_ns for s in jittered)
    late = [s.due_ns - (s.seen_ns or 0) for s in jittered]
    assert 0 <= min(late) <= max(late) <= 100 * MS


def test_loss_takes_about_its_share_and_leaves_the_numbers_of_the_rest():
    left = numbers(harmed(Loss(0.0, 1.0, 0.4)))
    assert left == sorted(set(left))
    assert 20 <= len(left) <= 40  # 30 expected; six standard deviations are 21


def test_duplicates_are_equal_to_the_byte():
    twice = harmed(Duplication(0.0, 1.0, 1.0, copies=3))
    assert numbers(twice) == [n for n in range(50) for _ in range(3)]
    assert all(a == b == c for a, b, c in zip(twice[::3], twice[1::3], twice[2::3], strict=True))


def test_what_is_held_back_is_overtaken_by_the_next():
    swapped = numbers(harmed(Reordering(0.1, 0.02, 1.0, held_s=0.03)))
    assert swapped[4:8] == [4, 6, 5, 7]


@pytest.mark.parametrize("what", list(Frozen))
def test_frozen_is_what_the_script_says_and_nothing_else(what: Frozen):
    frozen = harmed(Freezing(0.2, 0.2, what))[10:20]
    pictures = {s.payload for s in frozen}
    times = {stamp.time_ns for stamp in stamps(frozen)}
    counts = {Frozen.IMAGE: len(pictures), Frozen.SEQUENCE: len(set(numbers(frozen)))}
    counts[Frozen.TIME] = len(times)
    stuck = set(counts) if what is Frozen.MESSAGE else {what}
    assert counts == {part: 1 if part in stuck else 10 for part in counts}


def test_a_sender_that_returns_is_another_one_and_counts_from_0():
    sendings = harmed(Silence(0.2, 0.3))
    assert numbers(sendings) == [*range(10), *range(25)]
    assert len({sender(s) for s in sendings[:10]}) == len({sender(s) for s in sendings[10:]}) == 1
    assert sender(sendings[0]) != sender(sendings[-1])


def test_a_second_sender_speaks_beside_the_first_with_its_own_numbers_and_clock():
    sendings = harmed(SecondSender(0.2, 0.1, ahead_s=60.0))
    others = [s for s in sendings if sender(s) != sender(sendings[0])]
    assert numbers(others) == [0, 1, 2, 3, 4]
    assert len(sendings) == 55
    ahead_ms = [(stamp.time_ns - START_NS) // MS for stamp in stamps(others)]
    assert ahead_ms == [60_200, 60_220, 60_240, 60_260, 60_280]
    assert {s.seen_ns for s in others} == {None}


def test_a_second_sender_on_the_same_clock_is_as_good_as_the_first():
    others = harmed(SecondSender(0.0, 1.0, ahead_s=0.0))
    assert all(s.seen_ns is not None and is_usable(s) for s in others)


def test_a_clock_steps_and_returns():
    stepped = stamps(harmed(ClockStep(0.2, 0.1, step_s=-2.0)))
    pairs = zip(stepped, STREAM, strict=True)
    offsets_s = [(stamp.time_ns - time_ns) / 1e9 for stamp, (time_ns, _) in pairs]
    assert offsets_s == [0.0] * 10 + [-2.0] * 5 + [0.0] * 35


@pytest.mark.parametrize("how", list(Malformation))
def test_nothing_that_is_malformed_can_be_used(how: Malformation):
    sendings = harmed(Malformed(0.2, 0.1, how))
    assert [n for n, s in enumerate(sendings) if not is_usable(s)] == [10, 11, 12, 13, 14]
    assert [n for n, s in enumerate(sendings) if s.seen_ns is None] == [10, 11, 12, 13, 14]


def test_ten_consecutive_seeds_have_each_kind_once():
    for first in (0, 7, 190):
        kinds = [kind_of(random_script(seed).faults[0]) for seed in range(first, first + 10)]
        assert sorted(kinds) == sorted(KINDS)


def test_200_seeds_have_every_malformation_and_every_freezing():
    faults = [fault for seed in range(200) for fault in random_script(seed).faults]
    assert {f.how for f in faults if isinstance(f, Malformed)} == set(Malformation)
    assert {f.what for f in faults if isinstance(f, Freezing)} == set(Frozen)


@given(st.integers(0, 2**64 - 1))
@settings(max_examples=50, deadline=None)
def test_a_random_script_leaves_its_beginning_and_its_end_alone(seed: int):
    script = random_script(seed)
    assert min(fault.begin_s for fault in script.faults) >= 0.9
    assert script.end_s <= 2.4 < script.repeat_s


def test_a_file_says_the_same_as_the_dataclasses():
    text = """
    seed = 3
    repeat_s = 5
    [[fault]]
    kind = "delay"
    begin_s = 1
    duration_s = 0.5
    delay_s = 0.3
    [[fault]]
    kind = "malformed"
    begin_s = 2.0
    duration_s = 0.5
    how = "not-protobuf"
    [[fault]]
    kind = "freezing"
    begin_s = 3.0
    duration_s = 0.5
    what = "image"
    """
    assert parse_script(text) == FaultScript(
        (
            Delay(1, 0.5, 0.3),
            Malformed(2.0, 0.5, Malformation.NOT_PROTOBUF),
            Freezing(3.0, 0.5, Frozen.IMAGE),
        ),
        seed=3,
        repeat_s=5,
    )


ONE = '[[fault]]\nkind = "{}"\nbegin_s = 1\nduration_s = {}\n{}'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("seed = ", "TOML"),
        ("fault = 3", "[[fault]]"),
        ("sed = 3", "sed: unknown"),
        ("seed = -1", "0 to 2^64"),
        ("seed = 1.5", "line 1: seed: expected a whole number"),
        ("repeat_s = nan", "repeat_s"),
        ("[[fault]]\nbegin_s = 1", "kind: expected one of delay"),
        (ONE.format("zebra", 1, ""), "'zebra'"),
        (ONE.format("delay", 1, ""), "delay_s: missing"),
        (ONE.format("silence", 0, ""), "more than 0"),
        (ONE.format("silence", '"long"', ""), "line 4: fault[0].duration_s: expected a number"),
        (ONE.format("silence", "true", ""), "expected a number, got True"),
        (ONE.format("silence", "inf", ""), "duration_s"),
        (ONE.format("silence", 1, "share = 1"), "share: unknown"),
        (ONE.format("loss", 1, "share = 1.5"), "at most 1"),
        (ONE.format("duplication", 1, "share = 1\ncopies = 1"), "2 to 100"),
        (ONE.format("clock-step", 1, "step_s = 1e300"), "10^9"),
        (ONE.format("freezing", 1, 'what = "sound"'), "one of image, sequence"),
        (ONE.format("malformed", 1, "how = 3"), "one of not-protobuf"),
    ],
)
def test_a_script_that_makes_no_sense_is_refused_in_one_line(text: str, expected: str):
    with pytest.raises(UsageError) as refusal:
        parse_script(text)
    assert expected in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "name", ["seed:", "seed:x", "seed:-1", "seed:²", "seed:1e3", f"seed:{2**64}"]
)
def test_a_seed_that_is_none_is_refused(name: str):
    with pytest.raises(UsageError):
        script_named(name)


def test_the_delayed_sender_sends_everything_that_is_due_and_nothing_before():
    script = FaultScript((Jitter(0.0, 9.0, 0.03), Duplication(0.0, 9.0, 0.5)), seed=4)
    sent: list[tuple[int, Sending]] = []
    now_ns = time.monotonic_ns()
    times_ns = [now_ns + n * MS for n in range(40)]
    expected = list(transform(script, [(t, STREAM[0][1]) for t in times_ns]))
    with DelayedSender(
        script, lambda s: sent.append((time.monotonic_ns(), s)), time.monotonic_ns
    ) as to:
        for time_ns in times_ns:
            to.put(STREAM[0][1], time_ns)
        end_s = time.monotonic() + 10.0
        while len(sent) < len(expected) and time.monotonic() < end_s:
            time.sleep(0.005)
    assert [sending for _, sending in sent] == expected
    assert all(moment_ns >= sending.due_ns for moment_ns, sending in sent)


def test_a_delayed_sender_that_leaves_sends_no_more():
    sent: list[Sending] = []
    with DelayedSender(
        FaultScript((Delay(0.0, 9.0, 60.0),)), sent.append, time.monotonic_ns
    ) as sender:
        sender.put(STREAM[0][1], time.monotonic_ns())
    assert sent == []


def test_a_picture_of_three_channels_is_malformed_too():
    spec = replace(SPEC, channels=3)
    payload = encode_retina(np.zeros(spec.shape, np.uint8), spec, 0)
    stream = FaultyStream(FaultScript((Malformed(0.0, 1.0, Malformation.WRONG_CHANNELS),)))
    (sending,) = stream.say(payload, 0)
    message = Message("r/retina", sending.payload, sending.encoding, sending.attachment, 0)
    with pytest.raises(UnfitError):
        RetinaSense(spec).decode(message)
