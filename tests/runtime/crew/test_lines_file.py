"""Lines on the disk."""

from pathlib import Path

import pytest

from reflexarc_runtime.crew.lines_file import LinesFile, read_lines
from reflexarc_runtime.errors import UsageError


def test_a_line_that_was_torn_is_skipped_and_cut_off_before_the_next_one(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "rows.jsonl"
    assert read_lines(path) == []
    with LinesFile(path, "run") as file:
        file.append_line({"a": 1})
    path.write_bytes(path.read_bytes() + b'{"a": 2')
    assert read_lines(path) == [{"a": 1}]
    with LinesFile(path, "run") as file:
        file.append_line({"a": 3})
    assert read_lines(path) == [{"a": 1}, {"a": 3}]


def test_lines_that_are_no_objects_are_skipped(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_bytes(b'[1]\nnot JSON\n\xff\xfe\n{"a": 1}\n3\n')
    assert read_lines(path) == [{"a": 1}]


def test_a_file_that_is_emptied_begins_anew(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    path.write_bytes(b'{"a": 1}\n')
    with LinesFile(path, "run") as file:
        file.empty()
        file.append_line({"a": 2})
    assert read_lines(path) == [{"a": 2}]


def test_two_processes_do_not_write_into_one_folder(tmp_path: Path) -> None:
    with (
        LinesFile(tmp_path / "rows.jsonl", "run"),
        pytest.raises(UsageError, match="another run is running here"),
    ):
        LinesFile(tmp_path / "rows.jsonl", "run")
