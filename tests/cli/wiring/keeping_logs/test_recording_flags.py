"""Flags of a recording: numbers that cannot be meant are refused, and what they stand for."""

from pathlib import Path

import pytest

from reflexarc.main import main
from reflexarc.wiring.keeping_logs.black_box_flags import BlackBoxFlags
from reflexarc.wiring.keeping_logs.recording_flags import RecordingFlags, recording_place
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_runtime.errors import UsageError

MB = 1 << 20


@pytest.mark.parametrize("number", [-1.0, float("nan"), float("inf"), 1e12])
def test_a_reserve_that_is_no_size_is_refused(number):
    with pytest.raises(UsageError, match=r"^--reserve-mb: expected 0 to"):
        RecordingFlags(number).keeping("test")


def test_a_reserve_is_counted_in_mebibytes():
    assert RecordingFlags(1.5).keeping("test").reserve_bytes == 1536 * 1024
    assert RecordingFlags().keeping("test").reserve_bytes == 64 << 20


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (RecordingFlags(sync_s=-1.0), "--sync-s: expected 0 to"),
        (RecordingFlags(sync_s=float("nan")), "--sync-s: expected 0 to"),
        (RecordingFlags(rotate_mb=0.0), r"--rotate-mb: expected 0\.1 to"),
        (RecordingFlags(rotate_mb=float("inf")), "--rotate-mb: expected"),
        (RecordingFlags(rotate_s=0.5), "--rotate-s: expected 1 to"),
        (RecordingFlags(keep_mb=0.0), "--keep-mb: expected 1 to"),
        (
            RecordingFlags(keep_mb=15.0, rotate_mb=10.0),
            "--keep-mb: expected at least two parts, 20",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(flags, words):
    with pytest.raises(UsageError, match=words):
        flags.keeping("test")


def test_flags_are_counted_in_mebibytes_and_seconds():
    keeping = RecordingFlags(0.0, 2.0, 10.0, 60.0, 500.0).keeping("test")
    assert (keeping.reserve_bytes, keeping.sync_s) == (0, 2.0)
    assert (keeping.rotate_bytes, keeping.rotate_s, keeping.keep_bytes) == (10 * MB, 60.0, 500 * MB)
    assert keeping.who.startswith("test, process ")


def test_where_only_the_total_is_limited_a_part_is_a_tenth_of_it():
    assert RecordingFlags(keep_mb=500.0).keeping("test").most_bytes == 50 * MB
    assert RecordingFlags(keep_mb=500.0, rotate_s=1.0).keeping("test").most_bytes == 50 * MB
    assert RecordingFlags().keeping("test").most_bytes is None


def test_a_limit_is_reached_by_size_or_by_time():
    keeping = Keeping(rotate_bytes=10 * MB, rotate_s=60.0)
    assert keeping.exceeded(10 * MB - 1, 59.9) == ""
    assert keeping.exceeded(10 * MB, 0.0) == "10 MB"
    assert keeping.exceeded(0, 60.0) == "60 s"
    assert Keeping().exceeded(1 << 60, 1e9) == ""


def test_a_name_without_a_suffix_is_a_folder_for_parts_only(tmp_path: Path):
    parts = Keeping(rotate_s=1.0)
    assert recording_place(tmp_path / "monday", Keeping()) == tmp_path / "monday"
    assert not (tmp_path / "monday").exists()
    assert recording_place(tmp_path / "a" / "monday", parts) == tmp_path / "a" / "monday"
    assert (tmp_path / "a" / "monday").is_dir()
    assert recording_place(tmp_path / "b.mcap", parts) == tmp_path / "b.mcap"
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(UsageError, match="cannot be made"):
        recording_place(tmp_path / "file", parts)


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        (BlackBoxFlags(black_box=0.5), "--black-box: expected 1 to 3600"),
        (BlackBoxFlags(black_box=float("nan")), "--black-box: expected"),
        (BlackBoxFlags(black_box=5.0, black_box_after=-1.0), "--black-box-after: expected 0 to"),
        (BlackBoxFlags(black_box=5.0, black_box_keep_mb=0.0), "--black-box-keep-mb: expected 1"),
        (BlackBoxFlags(black_box_out=Path("x")), "-o: expected --black-box SECONDS beside it"),
    ],
)
def test_a_box_that_cannot_be_meant_is_refused(flags, words):
    with pytest.raises(UsageError, match=words):
        _ = flags.span


def test_a_box_without_a_place_gets_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flags = BlackBoxFlags(black_box=5.0)
    keeping = flags.keeping(RecordingFlags(rotate_s=1.0, sync_s=3.0).keeping("test"))
    assert (keeping.rotate_s, keeping.sync_s, keeping.keep_bytes) == (None, 3.0, 1024 * MB)
    place = flags.place(keeping)
    assert place.is_dir()
    assert (place.parent.name, place.name[-4:]) == ("runs", "-box")


def test_limits_of_parts_without_a_recording_are_refused(tmp_path, capsys):
    assert main(["run", str(tmp_path / "none.onnx"), "--rotate-s", "5"]) == 2
    assert "expected --record PATH beside" in capsys.readouterr().err
