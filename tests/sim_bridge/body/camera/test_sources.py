from pathlib import Path

import cv2
import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError, WorldError
from reflexarc_sim_bridge.body.camera.sources import source_named
from support.images import BLUE, RED, bar, write_image, write_video


def test_a_video_comes_frame_by_frame_with_its_rate(tmp_path: Path):
    path = tmp_path / "drive.avi"
    write_video(path, [bar(column) for column in range(0, 64, 16)], rate_hz=25.0)
    source = source_named(str(path))
    assert (source.rate_hz, source.total) == (25.0, 4)
    frames = [frame for frame in source.frames() if frame is not None]
    assert [int(frame[0, :, 0].argmax()) // 16 for frame in frames] == [0, 1, 2, 3]
    red, green, blue = frames[0][4, 4].astype(int)  # JPEG is not exact
    assert abs(red - RED[0]) < 30
    assert max(green, blue) < 60


def test_images_come_in_the_order_of_their_names_red_first(tmp_path: Path):
    for name, colour in (("b.png", BLUE), ("a.png", RED), ("c.bmp", RED)):
        write_image(tmp_path / name, bar(0, width=64, colour=colour))
    (tmp_path / "notes.txt").write_text("none")
    source = source_named(str(tmp_path))
    assert (source.rate_hz, source.total) == (None, 3)
    firsts = [tuple(f[0, 0].tolist()) for f in source.frames() if f is not None]
    assert firsts == [RED, BLUE, RED]
    assert source_named(str(tmp_path / "*.png")).total == 2
    assert source_named(str(tmp_path / "a.png")).total == 1


def test_an_image_that_cannot_be_decoded_is_none(tmp_path: Path):
    write_image(tmp_path / "a.png", bar(0))
    (tmp_path / "b.png").write_bytes(b"noise")
    (tmp_path / "c.png").write_bytes(b"")
    decoded = [frame is not None for frame in source_named(str(tmp_path)).frames()]
    assert decoded == [True, False, False]


def test_a_grey_image_has_three_equal_channels(tmp_path: Path):
    cv2.imwrite(str(tmp_path / "grey.png"), np.full((4, 4), 77, np.uint8))
    (frame,) = source_named(str(tmp_path / "grey.png")).frames()
    assert frame is not None
    assert frame.shape == (4, 4, 3)
    assert np.all(frame == 77)


def test_what_gives_no_images_is_refused(tmp_path: Path):
    text = tmp_path / "text.avi"
    text.write_text("none")
    for name in (text, tmp_path, tmp_path / "*.png", tmp_path / "none.avi"):
        with pytest.raises(UsageError, match="expected"):
            source_named(str(name))


def test_a_camera_that_is_not_there_is_refused():
    with pytest.raises(WorldError, match="camera 97"):
        source_named("97")
