"""A bit turned in what holds a file together costs no neighbour, makes no message, and is said."""

from pathlib import Path

import pytest
from mcap.opcode import Opcode

from campaigns.cuts import Mutant, judged, read_original
from reflexarc_logs.container.first_look import look
from reflexarc_logs.reading.recover import recover
from support.framing_judge import FramingJudge
from support.framing_logs import LAYOUTS, pieces

CHUNK_LENGTH = 9 + 28 + 4 + len("zstd")
"""Where in a record of a chunk the length of its data stands."""


@pytest.mark.parametrize("layout", LAYOUTS)
def test_a_bit_of_the_framing_loses_no_neighbour_and_invents_nothing(layout: str, tmp_path: Path):
    path = tmp_path / f"{layout}.mcap"
    LAYOUTS[layout](path)
    judge = FramingJudge(path, tmp_path)
    for flip in [*judge.flips()][11::331]:
        assert judge.faults(flip) == [], str(flip)


def turned(data: bytes, at: int, bit: int) -> Mutant:
    changed = bytes([data[at] ^ 1 << bit])
    return Mutant("turned", data[:at] + changed + data[at + 1 :], at, at + 1)


@pytest.mark.parametrize("layout", ["ours", "defaults"])
def test_a_message_index_that_calls_itself_a_message_is_none(layout: str, tmp_path: Path):
    LAYOUTS[layout](tmp_path / "log.mcap")
    original = read_original(tmp_path / "log.mcap")
    for piece in pieces(original.data):
        if piece.kind == Opcode.MESSAGE_INDEX:
            assert judged(original, turned(original.data, piece.start, 1), tmp_path)[0] == ""
            assert not look(tmp_path / "broken.mcap").complete


@pytest.mark.parametrize("layout", ["ours", "defaults"])
@pytest.mark.parametrize("at", [*range(CHUNK_LENGTH, CHUNK_LENGTH + 3)])
def test_the_length_inside_of_a_chunk_costs_that_chunk_alone(layout: str, at: int, tmp_path: Path):
    LAYOUTS[layout](tmp_path / "log.mcap")
    original = read_original(tmp_path / "log.mcap")
    for piece in [p for p in pieces(original.data) if p.kind == Opcode.CHUNK][::2]:
        for bit in range(8):
            mutant = turned(original.data, piece.start + at, bit)
            assert judged(original, mutant, tmp_path) == ("", "1")


def test_without_an_index_the_next_record_tells_where_a_broken_one_ends(tmp_path: Path):
    """The file ends before its index, so nothing but the records themselves is left."""
    LAYOUTS["ours"](tmp_path / "log.mcap")
    original = read_original(tmp_path / "log.mcap")
    (end,) = [p.start for p in pieces(original.data) if p.kind == Opcode.DATA_END]
    for piece in pieces(original.data[:end] + original.data[-8:]):
        if piece.kind in (Opcode.MESSAGE_INDEX, Opcode.CHUNK, Opcode.ATTACHMENT):
            for at in (0, 1, 2):
                whole = turned(original.data, piece.start + at, 1)
                cut = Mutant("cut", whole.data[:end], whole.first, whole.end)
                assert judged(original, cut, tmp_path)[0] == "", (piece, at)


def test_a_message_that_takes_in_the_next_one_is_not_believed(tmp_path: Path):
    """Records of 64 bytes: a length with its seventh bit turned ends with a later one."""
    path = tmp_path / "log.mcap"
    LAYOUTS["unchecked"](path)
    data = path.read_bytes()
    messages = [piece for piece in pieces(data) if piece.kind == Opcode.MESSAGE]
    assert {piece.end - piece.start for piece in messages} == {64}
    path.write_bytes(turned(data, messages[3].start + 1, 6).data)
    assert "23 messages, but by its own statistics 24" in look(path).damage
    saved = recover(path, tmp_path / "saved.mcap")
    assert (saved.messages, saved.exit_status) == (23, 1)
    kept = [piece for piece in pieces(saved.path.read_bytes()) if piece.kind == Opcode.MESSAGE]
    assert {piece.end - piece.start for piece in kept} == {64}


def test_what_an_index_says_of_a_channel_counts_more_than_the_channel(tmp_path: Path):
    """The index has a CRC; a channel outside of chunks has none."""
    path = tmp_path / "log.mcap"
    LAYOUTS["unchunked"](path)
    data = path.read_bytes()
    at = data.index(b"/topic1")
    path.write_bytes(turned(data, at + 1, 0).data)
    saved = recover(path, tmp_path / "saved.mcap")
    assert "the CRC of its data does not fit" in saved.doubt
    assert b"/uopic1" not in saved.path.read_bytes()
