"""The loop's encoder against `encode_tick`, which builds each message anew: the same bytes."""

import resource
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.decision import Command, Decision, Input, Timing, Verdict
from reflexarc_runtime.messages import tick_encoder
from reflexarc_runtime.messages.codec import encode_tick
from reflexarc_runtime.messages.tick_encoder import TickEncoder

UNSIGNED = st.integers(0, 2**64 - 1)
SIGNED = st.integers(-(2**63), 2**63 - 1)
NARROW = st.integers(-(2**31), 2**31 - 1)
SINGLES = st.lists(st.floats(width=32), max_size=4).map(tuple)
VERDICTS = st.sampled_from(Verdict)
USED = st.builds(Input, UNSIGNED, SIGNED, SIGNED, SIGNED)
COMMANDS = st.builds(
    Command,
    UNSIGNED,
    NARROW,
    VERDICTS,
    st.floats(),
    st.floats(),
    st.floats(),
    SIGNED,
    st.none() | UNSIGNED,
    st.none() | SIGNED,
    st.binary(max_size=20),
)
DECISIONS = st.builds(
    Decision,
    index=UNSIGNED,
    slot=UNSIGNED,
    now_ns=SIGNED,
    inputs=st.integers(0, 2**32 - 1),
    input=st.none() | USED,
    retina=st.binary(max_size=40),
    q_values=SINGLES,
    winner=NARROW,
    action=NARROW,
    verdict=VERDICTS,
    reason=st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
    command=COMMANDS,
    policy_hash=st.text("0123456789abcdef", max_size=64),
    state=SINGLES,
)
TIMINGS = st.builds(Timing, **{each.name: st.integers(-(2**61), 2**61) for each in fields(Timing)})
NOTHING = Decision(0, 0, 0, 0, None, b"", (), 0, 0, Verdict.OK, "", Command(0, 0, Verdict.OK, 0.0, 0.0, 0.0), "")  # fmt: skip  # noqa: E501
ZEROS = Timing(0, 0, 0, 0, 0, 0)


@given(
    st.lists(st.tuples(DECISIONS, TIMINGS), min_size=1, max_size=5),
    st.sampled_from([1, 300, 2**16]),
)
def test_ticks_one_after_the_other_have_the_bytes_of_each_by_itself(ticks, most_bytes):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tick_encoder, "MOST_BYTES", most_bytes)
        encoder = TickEncoder()
        for decision, timing in [*ticks, (NOTHING, ZEROS), *ticks]:
            assert encoder.encode(decision, timing) == encode_tick(decision, timing)


def resident_bytes() -> int:
    return int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize()


def test_what_was_encoded_is_not_kept():
    encoder = TickEncoder()
    large = replace(NOTHING, retina=bytes(20_000))
    before = resident_bytes()
    for _ in range(5000):  # 100 MB
        encoder.encode(large, ZEROS)
    assert resident_bytes() - before < 20_000_000


def test_a_text_that_cannot_be_encoded_leaves_nothing_behind():
    encoder, empty = TickEncoder(), encode_tick(NOTHING, ZEROS)
    wrong = Decision(9, 9, 9, 9, Input(9, 9, 9, 9), b"9", (9.0,), 9, 9, Verdict.OK, "\ud800", NOTHING.command, "")  # fmt: skip  # noqa: E501
    with suppress(UnicodeEncodeError, ValueError):
        encoder.encode(wrong, ZEROS)
    assert encoder.encode(NOTHING, ZEROS) == empty
