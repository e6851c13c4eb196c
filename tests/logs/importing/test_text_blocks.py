import io
from pathlib import Path

import pytest

from reflexarc_logs.importing import text_blocks as text_file
from reflexarc_logs.importing.text_blocks import text_blocks

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
