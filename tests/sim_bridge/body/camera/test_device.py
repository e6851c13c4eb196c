import os
import stat
from pathlib import Path

import cv2
import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError, WorldError
from reflexarc_sim_bridge.body.camera.sources import source_named

VIDEO_DRIVER = os.makedev(81, 0)


class FakeCapture:
    """A camera that gives three images and is unplugged."""

    opens = True
    addresses: list[object] = []  # noqa: RUF012  # what was opened, by any of them

    def __init__(self, address: object) -> None:
        self.addresses.append(address)
        self.left = 3

    def isOpened(self) -> bool:  # noqa: N802  # OpenCV's name
        return self.opens

    def set(self, *_: object) -> bool:
        return False

    def grab(self) -> bool:
        self.left -= 1
        return self.left >= 0

    def retrieve(self) -> tuple[bool, object]:
        return True, np.zeros((2, 2, 3), np.uint8)

    def release(self) -> None: ...


@pytest.fixture
def camera(monkeypatch: pytest.MonkeyPatch) -> type[FakeCapture]:
    """Every node under /dev is a camera's, and each camera can be opened."""
    FakeCapture.addresses = []
    monkeypatch.setattr(FakeCapture, "opens", True)
    monkeypatch.setattr(cv2, "VideoCapture", FakeCapture)
    real = Path.stat

    def node(path: Path, *, follow_symlinks: bool = True) -> os.stat_result:
        if str(path).startswith("/dev/video"):
            return os.stat_result((stat.S_IFCHR, *[0] * 9), {"st_rdev": VIDEO_DRIVER})
        return real(path, follow_symlinks=follow_symlinks)

    monkeypatch.setattr(Path, "stat", node)
    monkeypatch.setattr(os, "access", lambda *_: True)
    return FakeCapture


@pytest.mark.parametrize("name", ["0", "/dev/video0"])
def test_an_unplugged_camera_ends_with_its_name(camera: type[FakeCapture], name: str):
    frames = source_named(name).frames()
    assert [next(frames) is not None for _ in range(3)] == [True] * 3
    with pytest.raises(WorldError, match="camera 0: gives no more images; is it still plugged in"):
        next(frames)
    assert set(camera.addresses) == {0}


def test_a_camera_that_another_program_holds_is_refused(
    camera: type[FakeCapture], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(camera, "opens", False)
    with pytest.raises(WorldError, match=r"camera 0: .*another program"):
        source_named("/dev/video0")


@pytest.mark.usefixtures("camera")
def test_a_camera_without_rights_names_the_group(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(os, "access", lambda *_: False)
    with pytest.raises(WorldError, match=r"no right to /dev/video0; .*video"):
        source_named("0")


@pytest.mark.usefixtures("camera")
def test_bits_are_for_files():
    with pytest.raises(UsageError, match="--bits: expected image files, got 0"):
        source_named("0", bits=12)


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("97", "there is no /dev/video97"),
        ("/dev/video97", "there is no /dev/video97"),
        ("/dev/v4l/by-id/none", "there is no /dev/v4l/by-id/none"),
        ("/dev/null", "/dev/null is no camera"),
    ],
)
def test_what_is_no_camera_is_refused_at_once(name: str, reason: str):
    with pytest.raises(WorldError, match=f"camera .*: cannot be opened: {reason}"):
        source_named(name)


def test_a_number_is_a_camera_and_a_folder_of_that_name_is_pointed_to(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    Path("2024").mkdir()
    with pytest.raises(WorldError, match=r"\./2024"):
        source_named("2024")
