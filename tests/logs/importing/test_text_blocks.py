import gzip
import io
from pathlib import Path

import pytest

from reflexarc_logs.importing import metered
from reflexarc_logs.importing import text_blocks as text_file
from reflexarc_logs.importing.text_blocks import text_blocks
from reflexarc_runtime.errors import LogError

TEXT = b"one\ntwo\r\n\n" + b"x" * 40 + b"\nthree\rfour\v\n" + b"y" * 15 + b"\n" + b"z" * 16


@pytest.mark.parametrize("block_bytes", range(1, 30))
def test_lines_end_with_line_feeds_alone_and_long_ones_are_given_in_part(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, block_bytes: int
):
    monkeypatch.setattr(text_file, "_BLOCK_BYTES", block_bytes)
    monkeypatch.setattr(text_file, "MAX_LINE_BYTES", 16)
    path = tmp_path / "log.txt"
    path.write_bytes(TEXT)
    lines = [line for block in text_blocks(path) for line in block]
    assert lines == [line[:16] for line in io.BytesIO(TEXT).readlines()]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (
            b"version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 12345\n",
            "git lfs pull",
        ),
        ("FLASER 1".encode("utf-16"), "UTF-16"),
        (b"FLASER 1\rFLASER 2\r", "CR alone"),
    ],
)
def test_what_stands_in_place_of_a_text_log_is_named(tmp_path: Path, data: bytes, words: str):
    (tmp_path / "log.txt").write_bytes(data)
    with pytest.raises(LogError, match=words):
        list(text_blocks(tmp_path / "log.txt"))


def test_a_line_without_end_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(text_file, "MAX_LINE_BYTES", 1000)
    (tmp_path / "log.txt").write_bytes(b"x" * 1_000_000)
    with pytest.raises(LogError, match="a line of more than"):
        list(text_blocks(tmp_path / "log.txt"))


def test_a_file_that_unpacks_out_of_all_proportion_is_given_up(tmp_path: Path):
    path = tmp_path / "bomb.gz"
    for filler in (b"\n", b"x"):
        path.write_bytes(gzip.compress(filler * (metered.FREE_BYTES * 2), compresslevel=1))
        with pytest.raises(LogError, match="100 times its size"):
            for _ in text_blocks(path):
                pass


def test_a_small_file_may_unpack_to_any_multiple(tmp_path: Path):
    path = tmp_path / "log.gz"
    path.write_bytes(gzip.compress(b"FLASER\n" * 1_000_000))
    assert sum(map(len, text_blocks(path))) == 1_000_000
