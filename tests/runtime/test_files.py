import os
from collections.abc import Callable
from pathlib import Path
from typing import NoReturn

import pytest

from reflexarc_runtime.files import is_lfs_pointer, whole_file, write_atomically


def write_into(path: Path, data: bytes) -> None:
    with whole_file(path) as unfinished:
        unfinished.write_bytes(data)


WRITERS = pytest.mark.parametrize("write", [write_atomically, write_into])
Writer = Callable[[Path, bytes], None]


@WRITERS
def test_a_file_replaces_the_old_one_and_leaves_nothing_beside_it(write: Writer, tmp_path: Path):
    path = tmp_path / "file"
    for data in (b"old", b"new"):
        write(path, data)
        assert path.read_bytes() == data
    assert [p.name for p in tmp_path.iterdir()] == ["file"]
    assert path.stat().st_mode & 0o777 == 0o644


def test_the_folder_of_a_file_is_made(tmp_path: Path):
    write_atomically(tmp_path / "deep" / "er" / "file", b"data")
    assert (tmp_path / "deep" / "er" / "file").read_bytes() == b"data"


@WRITERS
@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_an_interrupted_write_leaves_the_old_file_and_nothing_else(
    write: Writer, error: type[BaseException], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def fail(*_: object) -> NoReturn:
        raise error

    path = tmp_path / "file"
    write(path, b"old")
    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(error):
        write(path, b"new")
    assert path.read_bytes() == b"old"
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_who_reads_meanwhile_meets_the_old_file(tmp_path: Path):
    path = tmp_path / "file"
    path.write_bytes(b"old")
    with whole_file(path) as unfinished:
        unfinished.write_bytes(b"half of the new")
        assert path.read_bytes() == b"old"
        unfinished.write_bytes(b"new")
    assert path.read_bytes() == b"new"


def test_the_note_of_git_lfs_is_told_from_any_other_file():
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n"
    assert is_lfs_pointer(pointer)
    assert is_lfs_pointer(pointer[:40])
    for other in (b"", pointer[:39], b"version 1.2", b" " + pointer, b"\x89PNG\r\n\x1a\n"):
        assert not is_lfs_pointer(other)
