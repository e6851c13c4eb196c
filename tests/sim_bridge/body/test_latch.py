from pathlib import Path

import pytest

from reflexarc_sim_bridge.body.latch import StopLatch


def test_a_stop_is_kept_until_its_reset(tmp_path: Path):
    folder = tmp_path / "runs"
    StopLatch(folder, "robot0").keep("fire")
    again = StopLatch(folder, "robot0")
    assert again.stopped == "fire"
    again.keep("")
    assert StopLatch(folder, "robot0").stopped == ""
    assert not [*folder.iterdir()]


def test_each_robot_has_its_own_whatever_its_name(tmp_path: Path):
    StopLatch(tmp_path, "hall/../robot0").keep("fire")
    assert StopLatch(tmp_path, "hall/../robot0").stopped == "fire"
    assert StopLatch(tmp_path, "robot0").stopped == ""


def test_a_file_that_says_nothing_or_cannot_be_read_stops_as_well(tmp_path: Path):
    (tmp_path / "robot0.stopped").write_bytes(b"")
    (tmp_path / "robot1.stopped").write_bytes(b"\xff\xfe")
    (tmp_path / "robot2.stopped").mkdir()
    for number in range(3):
        assert StopLatch(tmp_path, f"robot{number}").stopped


def test_a_disk_that_cannot_keep_it_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    (tmp_path / "runs").write_text("in the way")
    latch = StopLatch(tmp_path / "runs", "robot0")
    latch.keep("fire")
    assert "will not outlive" in caplog.text
