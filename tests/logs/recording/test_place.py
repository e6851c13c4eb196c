"""What became of an open file, told from real files and folders."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from reflexarc_logs.recording import place as place_module
from reflexarc_logs.recording.place import LostPlaceError, NoRoomError, Place

ROOM = os.statvfs_result((4096, 4096, 1000, 100, 100, 0, 0, 0, 0, 255))
"""1000 blocks of 4 KiB, of which 100 are free."""


class Open:
    """A file that is being written in a folder."""

    def __init__(self, folder: Path, reserve_bytes: int = 0) -> None:
        self.folder = folder / "runs"
        self.folder.mkdir()
        self.path, self.partial = self.folder / "a.mcap", self.folder / "a.mcap.partial"
        self.place = Place(self.path, reserve_bytes)
        self.file = self.partial.open("xb")

    def look(self) -> str:
        return self.place.look(self.path, self.partial, self.file.fileno())


@pytest.fixture
def opened(tmp_path):
    opened = Open(tmp_path)
    yield opened
    opened.file.close()


def replace_file(opened: Open) -> None:
    opened.partial.unlink()
    opened.partial.write_bytes(b"")


def remove_folder(opened: Open) -> None:
    opened.partial.unlink()
    opened.folder.rmdir()


def replace_folder(opened: Open) -> None:
    opened.folder.rename(opened.folder.with_name("before"))
    opened.folder.mkdir()


LOST: dict[str, Callable[[Open], object]] = {
    "the file was deleted": lambda o: o.partial.unlink(),
    "the file was moved": lambda o: o.partial.rename(o.folder / "b"),
    "the file was deleted, though another has its name": replace_file,
    "its folder is gone": remove_folder,
}


def test_a_file_that_is_where_it_should_be_is_fine(opened):
    assert opened.look() == ""


@pytest.mark.parametrize("words", LOST)
def test_a_lost_file_is_named_by_what_happened(words, opened):
    LOST[words](opened)
    with pytest.raises(LostPlaceError, match=f"^{words.partition(',')[0]}$"):
        opened.look()


def test_a_link_in_place_of_the_file_is_another_file(opened):
    opened.partial.rename(opened.folder / "b")
    opened.partial.symlink_to(opened.folder / "b")
    with pytest.raises(LostPlaceError, match=r"^another file took its place$"):
        opened.look()


def test_a_folder_that_was_renamed_and_made_anew_does_not_hold_the_file(opened):
    replace_folder(opened)
    with pytest.raises(LostPlaceError, match=r"^the file was moved$"):
        opened.look()


def test_a_file_of_the_final_name_is_said_and_harms_nothing_yet(opened):
    opened.path.write_bytes(b"")
    assert opened.look() == "another file got the name a.mcap"


def test_a_folder_that_cannot_be_written_is_said(opened, monkeypatch):
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may write everywhere
    assert opened.look() == "its folder cannot be written any more"


def test_a_folder_on_the_outer_disk_again_is_a_detached_disk(opened, monkeypatch):
    devices = {opened.folder: 7, opened.folder.parent: 1}
    monkeypatch.setattr(place_module, "_device", lambda folder: devices.get(folder, 1))
    place = Place(opened.path)
    opened.partial.unlink()
    devices[opened.folder] = 1
    with pytest.raises(LostPlaceError, match=r"^its disk was detached$"):
        place.look(opened.path, opened.partial, opened.file.fileno())
    with pytest.raises(LostPlaceError, match=r"^its disk was detached$"):
        place.check_ready()
    devices[opened.folder] = 9  # attached again: another device, as good as the first
    place.check_ready()


def test_the_reserve_is_what_was_asked_for_and_at_most_a_tenth_of_the_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "fstatvfs", lambda _: ROOM)
    monkeypatch.setattr(os, "statvfs", lambda _: ROOM)
    exact = Open(tmp_path, 100 * 4096)
    assert exact.look() == ""  # 100 blocks are free, 100 shall be
    exact.file.close()
    place = Place(exact.path, 1 << 40)
    place.check_room()  # a tenth is 100 blocks
    monkeypatch.setattr(os, "statvfs", lambda _: os.statvfs_result((*ROOM[:4], 99, *ROOM[5:])))
    with pytest.raises(NoRoomError, match=r"full but for 0\.4 MiB; 0\.4 MiB shall stay free"):
        place.check_room()
    Place(exact.path, 0).check_room()


def test_a_new_file_wants_twice_the_reserve_and_one_mebibyte_at_least(tmp_path, monkeypatch):
    free = {"blocks": 0}
    monkeypatch.setattr(
        os,
        "statvfs",
        lambda _: os.statvfs_result((4096, 4096, 100_000, 0, free["blocks"], 0, 0, 0, 0, 255)),
    )
    for reserve_blocks, wanted_blocks in ((0, 256), (1000, 2000)):
        place = Place(tmp_path / "a.mcap", reserve_blocks * 4096)
        free["blocks"] = wanted_blocks - 1
        with pytest.raises(NoRoomError):
            place.check_ready()
        free["blocks"] = wanted_blocks
        place.check_ready()


def test_a_file_system_that_tells_no_size_has_no_reserve(tmp_path, monkeypatch):
    monkeypatch.setattr(os, "statvfs", lambda _: os.statvfs_result((4096, 4096, *[0] * 7, 255)))
    Place(tmp_path / "a.mcap", 1 << 30).check_room()


def test_a_folder_that_was_removed_is_made_anew_for_the_next_part(tmp_path):
    place = Place(tmp_path / "runs" / "a.mcap")
    place.check_ready()
    assert (tmp_path / "runs").is_dir()
