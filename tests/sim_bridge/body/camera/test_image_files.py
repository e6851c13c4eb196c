import os
from pathlib import Path
from typing import IO, Any

import cv2
import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera import image_files
from reflexarc_sim_bridge.body.camera.eye import Image
from reflexarc_sim_bridge.body.camera.formats.facts import UnreadableImageError
from reflexarc_sim_bridge.body.camera.sources import ImageSource, source_named
from support.images import BLUE, RED, bar, write_image


def firsts(source: ImageSource) -> list[tuple[int, ...] | None]:
    """The first pixel of each image."""
    return [None if f is None else tuple(f[0, 0].tolist()) for f in source.frames()]


def solid(colour: tuple[int, int, int]) -> Image:
    return bar(0, width=64, colour=colour)


def write_deep(path: Path, *values: int) -> None:
    assert cv2.imwrite(str(path), np.array([values], np.uint16))


def test_a_folder_gives_its_visible_images_and_says_what_it_leaves_out(tmp_path: Path):
    write_image(tmp_path / "a2.png", solid(RED))
    write_image(tmp_path / "a10.png", solid(BLUE))
    (tmp_path / "a10.png").rename(tmp_path / "a10.PNG")
    for name in ("._a2.png", ".hidden.png", ".DS_Store", "Thumbs.db"):
        (tmp_path / name).write_bytes(b"x")
    (tmp_path / "a3.png").mkdir()
    said: list[str] = []
    source = source_named(str(tmp_path), say=said.append)
    assert firsts(source) == [RED, BLUE]
    assert said == ["2 images; left out, as no images: Thumbs.db and 1 more"]


def test_links_are_followed_and_one_that_leads_nowhere_is_counted_and_said(tmp_path: Path):
    (tmp_path / "store").mkdir()
    write_image(tmp_path / "store" / "x.png", solid(RED))
    folder = tmp_path / "links"
    folder.mkdir()
    (folder / "1.png").symlink_to(tmp_path / "store" / "x.png")
    (folder / "2.png").symlink_to(tmp_path / "nothing.png")
    (folder / "3.png").symlink_to(folder / "3.png")
    said: list[str] = []
    assert firsts(source_named(str(folder), say=said.append)) == [RED, None, None]
    assert [line.split()[0] for line in said] == ["2.png", "3.png"]


def test_a_broken_image_in_the_middle_is_said_and_keeps_its_place(tmp_path: Path):
    for name, colour in (("1.png", RED), ("3.png", BLUE)):
        write_image(tmp_path / name, solid(colour))
    (tmp_path / "2.png").write_bytes((tmp_path / "1.png").read_bytes()[:-20])
    said: list[str] = []
    assert firsts(source_named(str(tmp_path), say=said.append)) == [RED, None, BLUE]
    assert said == ["2.png is cut; not shown"]


def test_a_file_without_the_right_to_read_it_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    write_image(tmp_path / "1.png", solid(RED))
    write_image(tmp_path / "2.png", solid(RED))
    opened = Path.open

    def locked(path: Path, mode: str) -> IO[Any]:
        if path.name == "2.png":  # root may read everything, so the mode alone shows nothing
            raise PermissionError(13, "Permission denied", str(path))
        return opened(path, mode)

    monkeypatch.setattr(Path, "open", locked)
    said: list[str] = []
    assert firsts(source_named(str(tmp_path), say=said.append)) == [RED, None]
    assert said == ["2.png cannot be read: Permission denied; not shown"]


def test_where_no_image_can_be_read_all_reasons_are_told_once(tmp_path: Path):
    for number in range(3):
        (tmp_path / f"{number}.png").write_text("version https://git-lfs.github.com/spec/v1\n")
    (tmp_path / "3.jpg").write_bytes(b"")
    with pytest.raises(UsageError) as refused:
        source_named(str(tmp_path))
    said = str(refused.value)
    assert "no image could be read: 0.png is a Git LFS pointer" in said
    assert "(3 such files); 3.jpg is empty" in said


def test_names_in_other_bytes_than_utf_8_are_read(tmp_path: Path):
    write_image(tmp_path / "1.png", solid(RED))
    path = os.path.join(os.fsencode(tmp_path), b"2\xe9.png")
    os.rename(tmp_path / "1.png", path)
    (tmp_path / os.fsdecode(b"1\xe9.png")).write_bytes(b"")
    said: list[str] = []
    assert firsts(source_named(str(tmp_path), say=said.append)) == [None, RED]
    assert said == [r"1\udce9.png is empty; not shown"]


def test_deep_images_show_their_depth_together(tmp_path: Path):
    write_deep(tmp_path / "1.png", 0, 1000)
    write_deep(tmp_path / "2.png", 0, 65535)
    seen = [f for f in source_named(str(tmp_path)).frames() if f is not None]
    assert [int(f.max()) for f in seen] == [4, 255]  # 1000 · 255 / 65535 = 3.9


def test_deep_images_that_are_all_dark_are_refused_with_the_largest_value(tmp_path: Path):
    write_deep(tmp_path / "1.png", 0, 1000)
    write_deep(tmp_path / "2.png", 0, 4080)
    with pytest.raises(UsageError, match=r"up to 4080; .*--bits 12"):
        source_named(str(tmp_path))
    seen = [f for f in source_named(str(tmp_path), bits=12).frames() if f is not None]
    assert [int(f.max()) for f in seen] == [62, 254]  # 62.3, 254.1


def test_a_deep_image_behind_one_of_eight_bits_is_not_shown_as_nothing(tmp_path: Path):
    write_image(tmp_path / "1.png", solid(RED))
    write_deep(tmp_path / "2.png", 0, 4080)
    with pytest.raises(UsageError, match=r"2\.png: .*--bits 12"):
        firsts(source_named(str(tmp_path)))


def test_images_of_another_size_are_said(tmp_path: Path):
    write_image(tmp_path / "1.png", solid(RED))
    write_image(tmp_path / "2.png", bar(0, width=9, columns=9))
    said: list[str] = []
    assert firsts(source_named(str(tmp_path), say=said.append)) == [RED, RED]
    assert said == ["2.png: another size; it too is spread over the whole eye"]


def test_images_that_come_while_a_folder_is_shown_are_counted(tmp_path: Path):
    write_image(tmp_path / "1.png", solid(RED))
    said: list[str] = []
    frames = source_named(str(tmp_path), say=said.append).frames()
    next(frames)
    write_image(tmp_path / "2.png", solid(RED))
    assert list(frames) == []
    assert len(said) == 1
    assert "1 images came meanwhile" in said[0]


def test_two_series_are_refused_and_a_glob_takes_one(tmp_path: Path):
    folder = tmp_path / "run [1]"
    folder.mkdir()
    for number in (1, 2, 10):
        write_image(folder / f"left_{number}.png", solid(RED))
        write_image(folder / f"right_{number}.png", solid(BLUE))
    with pytest.raises(UsageError, match="one series"):
        source_named(str(folder))
    with pytest.raises(UsageError, match="one series"):
        source_named(str(folder / "*.png"))
    assert firsts(source_named(str(folder / "right_*.png"))) == [BLUE] * 3


def test_an_image_of_any_name_is_read_as_an_image(tmp_path: Path):
    write_deep(tmp_path / "1.png", 0, 4080)
    (tmp_path / "1.png").rename(tmp_path / "grab")
    with pytest.raises(UsageError, match="--bits 12"):
        source_named(str(tmp_path / "grab"))


def test_a_file_without_end_is_not_read_to_its_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(image_files, "MOST_BYTES", 1 << 20)
    (tmp_path / "x.png").symlink_to("/dev/zero")
    with pytest.raises(UnreadableImageError, match="larger than 1 MiB"):
        image_files.picture_in(tmp_path / "x.png")
