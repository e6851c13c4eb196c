"""Recordings whose disk fails: what is said, what is kept, how it goes on."""

import errno
import logging
import os
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.container import unfinished
from reflexarc_logs.container import writing as log_file
from reflexarc_logs.container.first_look import look
from reflexarc_logs.container.manifest import read_manifest
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.recording import recorder as recorder_module
from reflexarc_logs.recording import scribe as scribe_module
from reflexarc_logs.recording import series as series_module
from reflexarc_logs.recording.backlog import Backlog
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.part import PART, Head, next_path
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.recording.series import Series
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from support.bad_disks import Disks, Hanging, full_after
from support.policies import exported
from support.recordings import CONTRACT, RUN, WALL_OFFSET_NS, drive, nominal

TICKS = 600
ROOM = 25_000


@pytest.fixture(scope="module")
def policy() -> bytes:
    return exported(CONTRACT, 3, "Relu")


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Nothing is waited for: a drive of twelve seconds takes one, and chunks are small."""
    monkeypatch.setattr(log_file, "CHUNK_BYTES", 4096)
    monkeypatch.setattr(series_module, "RETRY_S", 0.0)
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.01)


@pytest.fixture
def disks(monkeypatch) -> Callable[..., None]:
    def become(*fails: Callable[[int], None]) -> None:
        monkeypatch.setattr(unfinished, "open_for_writing", Disks(*fails))

    return become


def recorder_at(path: Path, run=RUN, **more) -> Recorder:
    return Recorder(path, run, b"", {}, wall_offset_ns=WALL_OFFSET_NS, **more)


def until(holds: Callable[[], bool]) -> None:
    end_s = time.monotonic() + 30.0
    while not holds():
        assert time.monotonic() < end_s
        time.sleep(0.005)


def ticks_of(path: Path) -> list[int]:
    return [tick.decision.index for tick in read_log(path).ticks()]


@pytest.mark.parametrize(
    "number", [errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS, errno.EIO, errno.ENODEV]
)
def test_a_disk_that_fails_ends_a_part_and_the_next_begins_with_a_keyframe(
    number, policy, tmp_path, disks, caplog
):
    disks(full_after(ROOM, number))
    with caplog.at_level(logging.WARNING):
        drive(tmp_path / "a.mcap", policy, nominal(TICKS), TICKS)
    assert os.strerror(number) in caplog.text
    assert "the recording goes on" in caplog.text
    second = tmp_path / "a.part2.mcap"
    assert sorted(tmp_path.glob("*.mcap*")) == [tmp_path / "a.mcap.partial", second]
    first, other = read_manifest(tmp_path / "a.parts.jsonl")
    assert (first.state, first.why, first.path.name) == ("failed", os.strerror(number), "a.mcap")
    assert (other.state, other.why, other.path) == ("finished", os.strerror(number), second)
    said = look(second).metadata[PART]
    assert (said["part"], said["of"], said["after"]) == ("2", "a.mcap", os.strerror(number))
    report = replay(second)
    assert report.exit_status == 0
    assert [level.level for level in report.levels] == ["policy", "node"]
    assert ticks_of(second)[-1] == TICKS  # the farewell is the last
    recover(tmp_path / "a.mcap.partial", tmp_path / "b.mcap")
    assert replay(tmp_path / "b.mcap").exit_status == 0
    lost = set(range(TICKS)) - {*ticks_of(tmp_path / "b.mcap"), *ticks_of(second)}
    assert len(lost) < TICKS / 2  # none, if the disk failed right before a keyframe


def test_every_part_counts_and_all_are_named(policy, tmp_path, disks):
    disks(full_after(ROOM), full_after(ROOM))
    drive(tmp_path / "a.mcap", policy, nominal(TICKS), TICKS)
    names = sorted(path.name for path in tmp_path.glob("*.mcap*"))
    assert names == ["a.mcap.partial", "a.part2.mcap.partial", "a.part3.mcap"]


def test_a_recording_that_failed_and_went_on_says_both(policy, tmp_path, disks):
    disks(full_after(ROOM))
    recorders: list[Recorder] = []

    class Kept(Recorder):
        def __enter__(self):
            recorders.append(self)
            return self

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("support.recordings.Recorder", Kept)
        drive(tmp_path / "a.mcap", policy, nominal(TICKS), TICKS)
    (recorder,) = recorders
    assert recorder.failed
    assert recorder.state == "off, again in a.part2.mcap after: No space left on device"
    assert recorder.parts == (tmp_path / "a.mcap.partial", tmp_path / "a.part2.mcap")


def test_a_name_that_is_taken_is_skipped_for_the_next_part(tmp_path):
    first = tmp_path / "a.b.mcap"
    assert next_path(first, 2) == (tmp_path / "a.b.part2.mcap", 2)
    (tmp_path / "a.b.part2.mcap").touch()
    (tmp_path / "a.b.part3.mcap.partial").touch()
    (tmp_path / "a.b.part4.mcap").symlink_to("nowhere")
    assert next_path(first, 2) == (tmp_path / "a.b.part5.mcap", 5)
    assert next_path(first, 1_000_001) is None


LOSSES = {
    "the file was deleted": lambda path: path.with_name("a.mcap.partial").unlink(),
    "its folder is gone": lambda path: path.parent.rename(path.parent.with_name("before")),
}


@pytest.mark.parametrize("words", LOSSES)
def test_a_file_that_is_lost_is_said_and_the_status_is_not_on(words, tmp_path):
    path = tmp_path / "runs" / "a.mcap"
    path.parent.mkdir()
    with recorder_at(path) as recorder:
        assert recorder.state == "on"
        LOSSES[words](path)
        until(lambda: recorder.state != "on")
        assert recorder.state == f"stopped: {words}"
    assert recorder.failed
    assert recorder.parts == ()


def test_another_file_in_its_place_never_becomes_the_log(tmp_path, monkeypatch):
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 60.0)  # only the end looks
    partial = tmp_path / "a.mcap.partial"
    with recorder_at(tmp_path / "a.mcap") as recorder:
        partial.unlink()
        partial.write_bytes(b"somebody else's")
    assert recorder.state == "stopped: the file was deleted"
    assert not (tmp_path / "a.mcap").exists()
    assert partial.read_bytes() == b"somebody else's"


def test_a_file_whose_folder_was_renamed_is_a_whole_log_there(tmp_path):
    path = tmp_path / "runs" / "a.mcap"
    path.parent.mkdir()
    with recorder_at(path) as recorder:
        path.parent.rename(tmp_path / "before")
        until(lambda: recorder.state != "on")
    assert look(tmp_path / "before" / "a.mcap.partial").complete


def test_a_name_that_somebody_takes_is_said_and_the_log_keeps_the_other_one(tmp_path, caplog):
    with recorder_at(tmp_path / "a.mcap") as recorder:
        (tmp_path / "a.mcap").write_bytes(b"precious")
        until(lambda: recorder.state == "on, another file got the name a.mcap")
        until(lambda: "got the name a.mcap: it will stay unfinished" in caplog.text)
        time.sleep(0.05)
    assert caplog.text.count("unfinished") == 1  # it was looked at several times
    assert recorder.failed
    assert recorder.state.startswith("stopped: ")
    assert (tmp_path / "a.mcap").read_bytes() == b"precious"
    assert recorder.parts == (tmp_path / "a.mcap.partial",)
    assert look(tmp_path / "a.mcap.partial").complete


@pytest.fixture
def free(monkeypatch) -> dict[str, int]:
    """How many blocks are free on a disk of 5000, of 4 KiB each."""
    free = {"blocks": 1000}

    def disk(_: object) -> os.statvfs_result:
        return os.statvfs_result((4096, 4096, 5000, 0, free["blocks"], 0, 0, 0, 0, 255))

    monkeypatch.setattr(os, "fstatvfs", disk)
    monkeypatch.setattr(os, "statvfs", disk)
    return free


def test_a_disk_with_less_than_the_reserve_is_refused_and_nothing_is_left(tmp_path, free):
    free["blocks"] = 499
    with pytest.raises(
        LogError, match=r"2\.0 MiB shall stay free; make room, or see --reserve-mb$"
    ):
        recorder_at(tmp_path / "a.mcap")
    assert not list(tmp_path.iterdir())


def test_a_new_part_waits_for_twice_the_reserve(tmp_path, free):
    message = nominal(1)[1][0]
    with recorder_at(tmp_path / "a.mcap", replace(RUN, recorded_by="record")) as recorder:
        free["blocks"] = 499
        until(lambda: recorder.state.startswith("stopped"))
        free["blocks"] = 999
        for _ in range(5):
            recorder.put(message)
            time.sleep(0.02)
        assert recorder.state.startswith("stopped")
        free["blocks"] = 1000
        recorder.put(message)
        until(lambda: recorder.state.startswith("on, again in a.part2.mcap"))
    assert look(tmp_path / "a.part2.mcap").metadata[PART]["lost"] == "5"
    assert len(list(read_log(tmp_path / "a.part2.mcap").records())) == 1


def test_parts_that_do_not_last_are_begun_ever_more_rarely(tmp_path, monkeypatch):
    now = {"s": 100.0}
    monkeypatch.setattr(time, "monotonic", lambda: now["s"])
    monkeypatch.setattr(series_module, "RETRY_S", 1.0)
    series = Series(tmp_path / "a.mcap", Head(RUN, b"", {}), Keeping(reserve_bytes=0))
    waits = []
    for _ in range(8):
        assert series.current is not None
        series.current.abandon()
        series.failed()
        begun_s = now["s"]
        while series.begin("a fault", 0) is None:
            now["s"] += 1.0
        waits.append(now["s"] - begun_s)
    assert waits == [1, 2, 4, 8, 16, 32, 60, 60]
    now["s"] += 10.0  # this one lasted
    series.current.abandon()
    series.failed()
    now["s"] += 1.0
    assert series.begin("a fault", 0) is not None
    series.current.abandon()


def test_a_reserve_ends_the_part_as_a_finished_log(tmp_path, free):
    with recorder_at(tmp_path / "a.mcap") as recorder:
        free["blocks"] = 499
        until(lambda: recorder.state != "on")
        assert (
            recorder.state == "stopped: the disk is full but for 1.9 MiB; 2.0 MiB shall stay free"
        )
        until(lambda: (tmp_path / "a.mcap").exists())
    assert recorder.failed
    assert recorder.parts == (tmp_path / "a.mcap",)
    assert look(tmp_path / "a.mcap").complete


@pytest.mark.parametrize("number", [errno.EIO, errno.ENOSPC, errno.EDQUOT])
def test_a_sync_that_fails_fails_the_recording(number, tmp_path, monkeypatch):
    def refuse(_: int) -> None:
        raise OSError(number, os.strerror(number))

    with recorder_at(tmp_path / "a.mcap") as recorder:
        monkeypatch.setattr(os, "fsync", refuse)
    assert recorder.state == f"stopped: {os.strerror(number)}"
    assert recorder.parts == (tmp_path / "a.mcap.partial",)


def test_a_file_system_that_cannot_sync_is_no_failure(tmp_path, monkeypatch):
    def cannot(_: int) -> None:
        raise OSError(errno.EINVAL, os.strerror(errno.EINVAL))

    monkeypatch.setattr(os, "fsync", cannot)
    with recorder_at(tmp_path / "a.mcap") as recorder:
        pass
    assert (recorder.state, recorder.failed) == ("off", False)


def test_a_disk_that_hangs_is_said_and_is_not_waited_for_without_end(tmp_path, disks, monkeypatch):
    hanging = Hanging()
    disks(hanging)
    monkeypatch.setattr(recorder_module, "PATIENCE_S", 0.2)
    with recorder_at(tmp_path / "a.mcap") as recorder:
        hanging.hangs = True
        drive_messages = nominal(40)
        while "slow" not in recorder.state:
            for batch in drive_messages.values():
                for message in batch:
                    recorder.put(message)
            time.sleep(0.02)
        assert "the disk is slow: " in recorder.state
        assert recorder.state.startswith("on, ")
    assert recorder.state == "stopped: the disk did not answer for 0.2 s"
    assert recorder.failed
    hanging.release()


def test_what_was_dropped_is_said_and_is_in_the_log_before_its_end(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(recorder_module, "Backlog", lambda: Backlog(max_records=0))
    with recorder_at(tmp_path / "a.mcap") as recorder:
        recorder.put(next(iter(nominal(1)[1])))
        size = (tmp_path / "a.mcap.partial").stat().st_size
        until(lambda: (tmp_path / "a.mcap.partial").stat().st_size > size)
        cut = tmp_path / "cut.mcap.partial"
        cut.write_bytes((tmp_path / "a.mcap.partial").read_bytes())
        recorder.put(next(iter(nominal(1)[1])))
    assert look(cut).dropped == 1
    assert "the disk is too slow: 1 records dropped" in caplog.text
    assert read_log(tmp_path / "a.mcap").dropped == 2
    assert recorder.failed


def test_a_listener_s_next_part_begins_at_once(tmp_path, disks):
    disks(full_after(8_000))
    messages = [message for batch in nominal(400).values() for message in batch]
    with recorder_at(tmp_path / "a.mcap", replace(RUN, recorded_by="record")) as recorder:
        for message in messages:
            recorder.put(message)
    assert recorder.parts == (tmp_path / "a.mcap.partial", tmp_path / "a.part2.mcap")
    assert recorder.failed
    assert len(list(read_log(recorder.parts[-1]).records())) > 100
