import re
import struct
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]  # it ships no types
import numpy as np
import pytest
import zstandard
from mcap.writer import Writer

from reflexarc_logs.container.first_look import look
from reflexarc_logs.container.frames import MAX_HELD_BYTES
from reflexarc_logs.container.run_info import RUN
from reflexarc_logs.diffing.diff import diff
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from support.recordings import RUN as RUN_INFO
from support.recordings import WALL_OFFSET_NS, retina_at
from support.rewriting import edit_decision_schema, flip_bit, rewrite

MAGIC = b"\x89MCAP0\r\n"


def mcap_of_another_system(path: Path) -> None:
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        schema = writer.register_schema("std_msgs/String", "ros2msg", b"string data")
        writer.add_message(writer.register_channel("/chatter", "cdr", schema), 1, b"hello", 1)
        writer.finish()


def record(opcode: int, body: bytes, length: int | None = None) -> bytes:
    return struct.pack("<BQ", opcode, len(body) if length is None else length) + body


def chunk(data: bytes, claimed: int, compression: bytes = b"zstd") -> bytes:
    head = struct.pack("<QQQII", 0, 1, claimed, 0, len(compression)) + compression
    return record(6, head + struct.pack("<Q", len(data)) + data)


def with_run(after: bytes) -> bytes:
    """A log whose head is good, and what comes after it."""
    key, value = b"run_id", b"ab"
    pair = struct.pack("<I", len(key)) + key + struct.pack("<I", len(value)) + value
    name = RUN.encode()
    body = struct.pack("<I", len(name)) + name + struct.pack("<I", len(pair)) + pair
    return MAGIC + record(1, bytes(8)) + record(12, body) + after


def finished(data: bytes) -> bytes:
    return data + record(15, bytes(4)) + record(2, bytes(20)) + MAGIC


BAD = {
    "an empty file": (b"", "expected a log, got an empty file"),
    "a text": (b"hello, this is no log\n", "expected an MCAP file, got another kind"),
    "five bytes": (b"hello", "expected an MCAP file, got another kind"),
    "an ONNX model": (b"\x08\x08\x12\x07pytorch" * 9, "expected an MCAP file"),
    "the beginning alone": (MAGIC, "truncated before it says whose it is"),
    "a record longer than the file": (
        with_run(record(6, b"x" * 40, length=1 << 40)),
        "expected|damaged",
    ),
    "a field longer than the file": (
        with_run(record(12, struct.pack("<I", 0xFFFFFFFF) + b"x" * 20)),
        "damaged: a record shorter than its own fields",
    ),
    "a message shorter than its fields": (with_run(record(5, b"", length=3)), "damaged|truncated"),
    "no end of the data": (with_run(record(2, bytes(20)) + MAGIC), "its data has no end"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_file_is_refused_in_one_line(case, tmp_path):
    data, reason = BAD[case]
    path = tmp_path / "bad.mcap"
    path.write_bytes(data)
    with pytest.raises(LogError, match=reason) as caught:
        read_log(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_what_is_no_file_is_refused_in_one_line(tmp_path):
    for path in (tmp_path / "missing.mcap", tmp_path / ("n" * 300)):
        with pytest.raises(LogError, match=r"cannot be read: .+"):
            read_log(path)
    with pytest.raises(LogError, match=r"expected one log .* got a folder; .*reflexarc join"):
        read_log(tmp_path)


def test_a_log_of_another_system_is_refused(tmp_path):
    mcap_of_another_system(tmp_path / "other.mcap")
    with pytest.raises(LogError, match="a log of another system"):
        read_log(tmp_path / "other.mcap")


def bomb(size: int) -> bytes:
    return zstandard.ZstdCompressor(write_content_size=True).compress(bytes(size))


def unsized_bomb(size: int) -> bytes:
    return zstandard.ZstdCompressor(write_content_size=False).compress(bytes(size))


def lz4_bomb(size: int) -> bytes:
    return bytes(lz4.frame.compress(bytes(size), store_size=False))


BOMBS = {
    "a frame that says its size": (
        bomb(MAX_HELD_BYTES + 1),
        10,
        b"zstd",
        "damaged: .* not as long",
    ),
    "a header that says its size": (bomb(10), MAX_HELD_BYTES + 1, b"zstd", "more than the 128 MiB"),
    "a frame that hides its size": (unsized_bomb(MAX_HELD_BYTES + 1), 10, b"zstd", "damaged"),
    "no zstd at all": (b"not zstd", 10, b"zstd", "damaged"),
    "no lz4 at all": (b"not lz4", 10, b"lz4", "damaged"),
    "an lz4 frame that hides its size": (lz4_bomb(MAX_HELD_BYTES + 1), 10, b"lz4", "damaged"),
    "another compression": (b"", 10, b"bz2", "compressed with 'bz2', which is not read here"),
}


@pytest.mark.parametrize("case", BOMBS)
def test_a_chunk_that_would_unpack_to_too_much_is_never_unpacked(case, tmp_path):
    path = tmp_path / "bomb.mcap"
    data, claimed, compression, reason = BOMBS[case]
    path.write_bytes(finished(with_run(chunk(data, claimed, compression))))
    log = read_log(path)
    with pytest.raises(LogError, match=reason):
        list(log.records())


def test_a_flipped_bit_anywhere_in_the_file_is_noticed(log_path, tmp_path):
    data, path = log_path.read_bytes(), tmp_path / "flipped.mcap"
    for position in range(0, len(data), 67):
        path.write_bytes(flip_bit(data, position, position % 8))
        with pytest.raises(LogError) as caught:
            read_log(path)
        assert "\n" not in str(caught.value), position


def test_a_log_cut_anywhere_is_a_readable_prefix_or_a_clear_error(log_path, tmp_path):
    data, whole = log_path.read_bytes(), list(read_log(log_path).records())
    path, lengths = tmp_path / "cut.mcap", []
    last_field = data.index(b"wall_offset_ns")  # of the run's metadata: a name, 4 bytes, a value
    head = last_field + len("wall_offset_ns") + 4 + len(str(WALL_OFFSET_NS))
    for size in [*range(1, len(data), 500), len(data) - 1]:
        path.write_bytes(data[:size])
        with pytest.raises(LogError):
            read_log(path)
        if size < head:
            with pytest.raises(LogError, match=r"truncated before|another kind"):
                read_log(path, allow_truncated=True)
            continue
        log = read_log(path, allow_truncated=True)
        part = list(log.records())
        assert part == whole[: len(part)]
        assert not log.complete
        lengths.append(len(part))
    assert lengths == sorted(lengths)
    assert lengths[-1] == len(whole)


def test_bytes_after_the_end_of_a_log_are_noticed(log_path, tmp_path):
    (tmp_path / "log.mcap").write_bytes(log_path.read_bytes() + b"x")
    with pytest.raises(LogError, match="bytes after its end"):
        read_log(tmp_path / "log.mcap")


def test_a_truncated_log_names_the_command_that_saves_it(log_path, tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(log_path.read_bytes()[:9000])
    with pytest.raises(LogError, match=re.escape(f"`reflexarc recover {path} -o FIXED.mcap`")):
        read_log(path)


def test_zeros_after_a_power_cut_end_the_intact_part(log_path, tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(log_path.read_bytes()[:9000] + bytes(4096))
    log = read_log(path, allow_truncated=True)
    part = list(log.records())
    assert part == list(read_log(log_path).records())[: len(part)]
    assert part


def test_a_log_without_ticks_cannot_be_replayed(policy, tmp_path):
    path = tmp_path / "log.mcap"
    with Recorder(path, RUN_INFO, policy, {}, wall_offset_ns=0) as recorder:
        recorder.put(retina_at(1, np.zeros((1, 16, 1), np.uint8)))
    with pytest.raises(LogError, match=r"expected ticks .*, found none; nothing to replay"):
        replay(path)


def test_a_log_that_only_declares_ticks_compares_nothing_and_fails(log_path, tmp_path):
    path = rewrite(
        log_path, tmp_path / "log.mcap", lambda t, n, p: None if t.endswith("tick") else p
    )
    report = replay(path)
    assert report.exit_status == 2
    assert report.lines()[0].endswith("nothing was compared")


def test_a_malformed_schema_in_a_log_is_an_error_of_the_log(log_path, tmp_path):
    path = rewrite(log_path, tmp_path / "log.mcap", schema=lambda schema: b"\xff\xff")
    with pytest.raises(LogError, match=r"the schema of reflexarc.Tick is malformed"):
        replay(path)


def test_a_schema_with_a_field_of_an_unknown_type_is_an_error_of_the_log(log_path, tmp_path):
    def spoil(decision):
        decision.field[0].type_name = ".nowhere.Thing"
        decision.field[0].type = 11

    path = rewrite(log_path, tmp_path / "log.mcap", schema=edit_decision_schema(spoil))
    with pytest.raises(LogError, match="malformed"):
        replay(path)


@pytest.mark.parametrize(
    ("name", "value"),
    [("backend", "abacus"), ("clock", "sundial"), ("wall_offset_ns", "late"), ("versions", "[]")],
)
def test_run_metadata_that_cannot_be_is_refused(name, value, log_path, tmp_path):
    path = rewrite(log_path, tmp_path / "log.mcap", metadata={RUN: {name: value}})
    with pytest.raises(LogError, match=rf"reflexarc.run.{name}") as caught:
        read_log(path)
    assert "\n" not in str(caught.value)


def test_metadata_of_a_newer_version_is_left_alone(log_path, tmp_path):
    path = rewrite(log_path, tmp_path / "log.mcap", metadata={RUN: {"mood": "good"}})
    assert read_log(path).run == read_log(log_path).run


def test_a_log_without_chunks_reads_the_same(log_path, tmp_path):
    path = rewrite(log_path, tmp_path / "log.mcap", compression=False)
    assert list(read_log(path).records()) == list(read_log(log_path).records())


def test_a_summary_counts_what_is_there(log_path):
    found = summarise(log_path)
    counts = {topic.topic: topic.messages for topic in found.topics}
    assert counts == {
        "/robot0/command": 61,
        "/robot0/keyframe": 2,
        "/robot0/retina": 60,
        "/robot0/stop": 1,
        "/robot0/tick": 61,
    }
    retina = found.topics[2]
    assert retina.rate_hz == pytest.approx(50.0)
    assert retina.schema == "foxglove.RawImage"
    assert found.messages == 185
    assert found.complete
    assert found.bytes == log_path.stat().st_size
    assert found.duration_s == pytest.approx(59 * 0.02 + 0.003)
    assert found.policy_hash == read_log(log_path).run.policy_hash


def test_a_summary_of_a_truncated_log_says_so_and_counts_the_intact_part(log_path, tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(log_path.read_bytes()[:9000])
    found = summarise(path)
    assert not found.complete
    assert 0 < found.messages < 185


def test_a_git_lfs_pointer_is_called_one_by_every_reader(tmp_path):
    path = tmp_path / "drive.mcap"
    path.write_bytes(b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12\n")
    for read in (read_log, look, lambda p: diff(p, p), lambda p: recover(p, tmp_path / "o.mcap")):
        with pytest.raises(LogError, match="git lfs pull"):
            read(path)
