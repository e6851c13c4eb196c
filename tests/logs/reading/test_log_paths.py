"""Files and folders, and the logs that they mean."""

from pathlib import Path

import pytest

from reflexarc_logs.container.manifest import Manifest
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_runtime.errors import LogError


def test_a_folder_means_all_its_logs_in_the_same_order_everywhere(tmp_path: Path):
    for name in ("b/2.mcap", "a.mcap", "b/1.MCAP", "b/notes.txt", "c.mcap.partial"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    (tmp_path / "link.mcap").symlink_to(tmp_path / "a.mcap")
    found = [str(p.relative_to(tmp_path)) for p in log_paths([tmp_path])]
    assert found == ["a.mcap", "b/1.MCAP", "b/2.mcap", "link.mcap"]


def test_a_file_is_itself_even_if_it_is_not_there_and_only_once(tmp_path: Path):
    (tmp_path / "a.mcap").write_bytes(b"")
    named = [tmp_path / "none.txt", tmp_path, tmp_path / "a.mcap"]
    assert log_paths(named) == (tmp_path / "none.txt", tmp_path / "a.mcap")


def test_nothing_is_an_error(tmp_path: Path):
    with pytest.raises(LogError, match="expected logs"):
        log_paths([tmp_path])
    with pytest.raises(LogError, match="got nothing"):
        log_paths([])


def test_parts_come_in_the_order_of_their_numbers(tmp_path: Path):
    names = ["a.mcap", *(f"a.part{number}.mcap" for number in range(2, 12))]
    for name in sorted(names, reverse=True):
        (tmp_path / name).write_bytes(b"")
    assert [path.name for path in log_paths([tmp_path])] == names


def test_a_manifest_means_the_parts_of_its_recording_that_are_there(tmp_path: Path):
    manifest = Manifest(tmp_path / "a.mcap", "id")
    manifest.begin()
    for number in (1, 2, 3):
        manifest.say("finished", part=number, name=f"{number}.mcap")
    for name in ("2.mcap", "3.mcap", "another.mcap"):
        (tmp_path / name).write_bytes(b"")
    assert [path.name for path in log_paths([manifest.path])] == ["2.mcap", "3.mcap"]
    for name in ("2.mcap", "3.mcap"):
        (tmp_path / name).unlink()
    with pytest.raises(LogError, match="expected finished parts beside it"):
        log_paths([manifest.path])
