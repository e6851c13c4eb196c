import struct
from pathlib import Path

import cv2
import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.sources import source_named
from support.images import bar, write_video

ONE, NONE = 1 << 16, 0
LENGTH = 40


def turned_right(mp4: bytes) -> bytes:
    """The same MP4, whose track header asks for a turn by 90 degrees to the right."""
    upright = struct.pack(">9i", ONE, NONE, NONE, NONE, ONE, NONE, NONE, NONE, 1 << 30)
    right = struct.pack(">9i", NONE, ONE, NONE, -ONE, NONE, NONE, NONE, NONE, 1 << 30)
    at = mp4.index(upright, mp4.index(b"tkhd"))
    return mp4[:at] + right + mp4[at + len(right) :]


def test_a_video_that_was_held_askew_is_turned_upright(tmp_path: Path):
    path = tmp_path / "phone.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 32))
    image = np.zeros((32, 64, 3), np.uint8)
    image[:, :32] = 255  # the left half is white
    for _ in range(3):
        writer.write(image)
    writer.release()
    path.write_bytes(turned_right(path.read_bytes()))
    frame = next(iter(source_named(str(path)).frames()))
    assert frame is not None
    assert frame.shape == (64, 32, 3)
    assert frame[:28].mean() > 200  # what was left is now above
    assert frame[36:].mean() < 50


def test_a_video_that_ends_early_is_said(tmp_path: Path):
    path = tmp_path / "drive.avi"
    write_video(path, [bar(8) for _ in range(LENGTH)], rate_hz=25.0)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    said: list[str] = []
    source = source_named(str(path), say=said.append)
    count = len(list(source.frames()))
    assert 0 < count < LENGTH
    assert source.total in (count, LENGTH)
    if source.total == LENGTH:
        assert said == [f"{path}: ended after {count} of {LENGTH} images"]


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("empty.mp4", b"", "is empty"),
        ("lfs.mp4", b"version https://git-lfs.github.com/spec/v1\n", "Git LFS pointer"),
        ("noise.mp4", b"noise", "got neither"),
        ("anim.gif", b"GIF89a", "a kind of image that is not read"),
        ("light.exr", b"v/1\x01", "a kind of image that is not read"),
    ],
)
def test_what_is_no_video_is_refused(tmp_path: Path, name: str, content: bytes, reason: str):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(UsageError, match=reason):
        source_named(str(tmp_path / name))


def test_a_video_without_images_is_refused(tmp_path: Path):
    path = tmp_path / "none.avi"
    write_video(path, [bar(8)] * 3, rate_hz=25.0)
    data = path.read_bytes()
    path.write_bytes(data[: data.index(b"movi") + 4])  # the header alone
    with pytest.raises(UsageError, match=r"none\.avi"):
        source_named(str(path))
