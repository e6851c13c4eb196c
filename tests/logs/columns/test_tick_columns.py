"""The columns of ticks against protobuf, which decodes each by itself."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_logs.columns.tick_columns import ColumnReader
from reflexarc_logs.columns.tick_layout import layout_of
from reflexarc_logs.container.fields import MESSAGE
from reflexarc_logs.reading.channels import LogStream
from reflexarc_logs.reading.message_tables import MessageTable
from reflexarc_runtime.messages_pb2 import Tick

HASH = "ab" * 32
WORDS = st.integers(0, (1 << 63) - 1)
SMALL = st.integers(0, 300)
FLOATS = st.floats(width=32, allow_nan=False)


@st.composite
def ticks(draw: st.DrawFn) -> Tick:
    """Mostly such as a loop writes; some have another verdict, another policy, other sizes."""
    tick = Tick()
    decision = tick.decision
    decision.index, decision.slot, decision.now_ns = draw(SMALL), draw(WORDS), draw(WORDS)
    decision.inputs = draw(st.integers(0, 3))
    decision.action, decision.winner = draw(st.integers(-1, 3)), draw(st.integers(-1, 3))
    decision.verdict = draw(st.sampled_from([1, 1, 1, 3]))
    decision.policy_hash = draw(st.sampled_from([HASH, HASH, HASH, "", "cd" * 32]))
    decision.reason = draw(st.sampled_from(["", "", "", "why"]))
    decision.retina = draw(st.binary(min_size=4, max_size=4))
    decision.q_values.extend(draw(st.lists(FLOATS, min_size=3, max_size=3)))
    decision.input.age_ns = draw(SMALL)
    decision.command.sequence, decision.command.linear_mps = decision.index, draw(FLOATS)
    tick.timing.lateness_ns = draw(st.integers(-5, 100_000))
    return tick


def table_of(payloads: list[bytes]) -> MessageTable:
    content, begins, ends = b"", [], []
    for payload in payloads:
        begins.append(len(content))
        content += MESSAGE.pack(1, 0, 0, 0) + payload
        ends.append(len(content))
    return MessageTable(content, np.array(begins), np.array(ends), {1: LogStream("/t", "", b"")})


def read(payloads: list[bytes], commands: list[bytes]):
    """The columns of ticks, each followed by its command."""
    pairs = zip(payloads, commands, strict=True)
    table = table_of([one for pair in pairs for one in pair])
    places = np.arange(0, len(table), 2)
    return ColumnReader(HASH).read(table, places, places + 1)


def own(tick: Tick) -> bytes:
    return tick.decision.command.SerializeToString()


@settings(max_examples=150, deadline=None)
@given(st.lists(ticks(), min_size=1, max_size=12))
def test_what_is_usual_says_what_protobuf_says(many: list[Tick]) -> None:
    columns = read([t.SerializeToString() for t in many], [own(t) for t in many])
    for row, tick in enumerate(many):
        decision = tick.decision
        is_named = decision.policy_hash in ("", HASH)
        is_usual = decision.verdict == 1 and is_named and not decision.reason
        assert (columns is not None and bool(columns.usual[row])) == is_usual
        if not is_usual:
            continue
        for name, numbers in columns.numbers.items():
            assert numbers[row] == getattr(decision, name)
        assert columns.retinas[row].tobytes() == decision.retina
        q_values = columns.q_values[row].view("<f4")
        assert q_values.tobytes() == np.array(decision.q_values, "<f4").tobytes()


def good(index: int = 7) -> Tick:
    tick = Tick()
    decision = tick.decision
    decision.index = decision.slot = index
    decision.now_ns, decision.verdict, decision.policy_hash = 10**12, 1, HASH
    decision.retina, decision.command.sequence = bytes(4), index
    decision.q_values.extend([1.0, 2.0, 3.0])
    tick.timing.wake_ns = 10**12
    return tick


def test_an_ordinary_tick_is_usual() -> None:
    columns = read(
        [good(i).SerializeToString() for i in range(300)], [own(good(i)) for i in range(300)]
    )
    assert columns.usual.all()
    assert columns.numbers["index"].tolist() == [*range(300)]


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 255))
def test_a_byte_that_was_changed_is_seen_or_says_what_protobuf_says(at: int, flip: int) -> None:
    whole = good().SerializeToString()
    damaged = bytearray(whole)
    damaged[at % len(whole)] ^= flip
    columns = read([whole, bytes(damaged)], [own(good())] * 2)
    if columns.usual[1]:
        decision = Tick.FromString(bytes(damaged)).decision
        assert own(Tick.FromString(bytes(damaged))) == own(good())
        assert (decision.verdict, decision.policy_hash, decision.reason) == (1, HASH, "")
        for name, numbers in columns.numbers.items():
            assert numbers[1] == getattr(decision, name)


def test_a_command_that_differs_is_not_passed_over() -> None:
    other = good()
    other.decision.command.linear_mps = 0.5
    longer = own(good()) + b"\x08\x07"
    payloads = [good().SerializeToString()] * 3
    columns = read(payloads, [own(good()), own(other), longer])
    assert columns.usual.tolist() == [True, False, False]


@pytest.mark.parametrize(
    "changed",
    [
        lambda tick: tick + b"\x12\x02\x08",  # a timing that is cut short
        lambda tick: tick[:-1],
        lambda tick: b"",
        lambda tick: b"\xff" * 40,
        lambda tick: b"\x0a\x02\x08\x80" + tick,
    ],
)
def test_what_cannot_be_decoded_is_not_usual(changed) -> None:
    whole = good().SerializeToString()
    columns = read([whole, changed(whole)], [own(good())] * 2)
    assert columns.usual.tolist() == [True, False]


def test_fields_that_come_twice_or_are_not_known_have_no_layout() -> None:
    whole = good().SerializeToString()
    assert layout_of(whole, HASH) is not None
    decision = good().decision.SerializeToString()
    for behind in (b"\x08\x01", b"\xf8\x07\x01"):
        changed = decision + behind
        assert len(changed) < 128
        assert layout_of(bytes([0x0A, len(changed)]) + changed, HASH) is None
