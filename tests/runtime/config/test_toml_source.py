"""TOML as editors of Windows write it."""

import codecs
from pathlib import Path

import pytest

from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import UsageError

TEXT = 'name = "mine"\n\n[limits]\nlinear_mps = 0.5\n'


def written(folder: Path, data: bytes) -> Path:
    path = folder / "settings.toml"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("mark", [b"", codecs.BOM_UTF8])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_marks_of_windows_change_nothing(tmp_path: Path, mark: bytes, end: str):
    path = written(tmp_path, mark + TEXT.replace("\n", end).encode())
    assert read_text(path, "here") == TEXT


def test_a_complaint_about_such_a_file_names_the_right_line(tmp_path: Path):
    path = written(tmp_path, codecs.BOM_UTF8 + TEXT.replace("\n", "\r\n").encode())
    source = TomlSource(read_text(path, "here"), "here")
    assert str(source.complaint(("limits", "linear_mps"), "no")).startswith("here:4: ")


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_utf_16_is_named(tmp_path: Path, encoding: str):
    mark = {"utf-16-le": codecs.BOM_UTF16_LE, "utf-16-be": codecs.BOM_UTF16_BE}[encoding]
    path = written(tmp_path, mark + TEXT.encode(encoding))
    with pytest.raises(UsageError, match="got UTF-16, as its byte order mark says"):
        read_text(path, "here")
