"""A disk that takes its time with a sync holds nothing up: all goes to the system meanwhile."""

import errno
import os
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import pytest

from reflexarc_logs.container.manifest import read_manifest
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.recording import scribe as scribe_module
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.recording.syncer import Syncer
from reflexarc_logs.replaying.replay import replay
from support.bad_disks import Disks
from support.policies import exported
from support.recordings import CONTRACT, RUN, WALL_OFFSET_NS, drive, nominal


@dataclass
class SlowDisk:
    """A disk whose syncs wait until they are let through."""

    through: threading.Event = field(default_factory=threading.Event)
    asked: int = 0

    def sync(self, _: int) -> None:
        self.asked += 1
        self.through.wait(30.0)


@pytest.fixture
def disk(monkeypatch) -> Iterator[SlowDisk]:
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.01)
    disk = SlowDisk()
    monkeypatch.setattr(os, "fsync", disk.sync)
    yield disk
    disk.through.set()


def until(holds: Callable[[], bool]) -> None:
    end_s = time.monotonic() + 30.0
    while not holds():
        assert time.monotonic() < end_s
        time.sleep(0.005)


def test_what_comes_during_a_sync_is_safe_from_a_kill(disk, tmp_path):
    messages = [message for batch in nominal(200).values() for message in batch]
    partial = tmp_path / "a.mcap.partial"
    keeping = Keeping(sync_s=0.0)
    with Recorder(
        tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=WALL_OFFSET_NS, keeping=keeping
    ) as recorder:
        until(lambda: disk.asked == 1)
        for message in messages:
            recorder.put(message)
        records = lambda: list(read_log(partial, allow_truncated=True).records())  # noqa: E731  # short
        until(lambda: len(records()) == len(messages))
        until(lambda: recorder.state.startswith("on, the disk is slow: busy for"))
        assert disk.asked == 1  # no second one while the first is under way
        killed = tmp_path / "killed.mcap.partial"
        killed.write_bytes(partial.read_bytes())
        disk.through.set()
    assert recover(killed, tmp_path / "killed.mcap").messages == len(messages)
    assert (recorder.state, recorder.failed) == ("off", False)


def test_the_next_part_does_not_wait_for_the_last_one_s_sync(disk, tmp_path):
    policy = exported(CONTRACT, 3, "Relu")
    seen: list[set[str]] = []

    def let_through() -> None:
        until(lambda: (tmp_path / "a.part4.mcap.partial").exists())
        seen.append({path.name for path in tmp_path.glob("*.mcap*")})
        disk.through.set()

    watcher = threading.Thread(target=let_through)
    watcher.start()
    drive(tmp_path / "a.mcap", policy, nominal(400), 400, keeping=Keeping(rotate_s=2.0))
    watcher.join()
    assert seen == [{f"a{part}.mcap.partial" for part in ("", ".part2", ".part3", ".part4")}]
    assert [part.state for part in read_manifest(tmp_path / "a.parts.jsonl")] == ["finished"] * 4
    parts = log_paths([tmp_path])
    assert len(parts) == 4
    assert all(replay(part).exit_status == 0 for part in parts)


def test_a_part_that_cannot_get_its_name_is_a_failure_and_the_next_goes_on(disk, tmp_path):
    policy = exported(CONTRACT, 3, "Relu")
    states: list[Recorder] = []

    def take_the_name() -> None:
        until(lambda: (tmp_path / "a.part2.mcap.partial").exists())
        (tmp_path / "a.mcap").write_bytes(b"precious")
        disk.through.set()

    class Kept(Recorder):
        def __enter__(self):
            states.append(self)
            return self

    watcher = threading.Thread(target=take_the_name)
    watcher.start()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("support.recordings.Recorder", Kept)
        drive(tmp_path / "a.mcap", policy, nominal(200), 200, keeping=Keeping(rotate_s=2.0))
    watcher.join()
    assert (tmp_path / "a.mcap").read_bytes() == b"precious"
    assert replay(tmp_path / "a.part2.mcap").exit_status == 0
    assert states[0].failed
    assert recover(tmp_path / "a.mcap.partial", tmp_path / "saved.mcap").was_complete


def test_a_disk_that_turns_read_only_after_a_sync_that_failed_is_named_by_the_sync(
    tmp_path, monkeypatch
):
    """ext4 does so: the next write is refused before anyone has heard of the sync."""
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.05)
    read_only = threading.Event()

    def sync(_: int) -> None:
        read_only.set()
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    def refuse(_: int) -> None:
        if read_only.is_set():
            raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(os, "fsync", sync)
    monkeypatch.setattr("reflexarc_logs.container.unfinished.open_for_writing", Disks(refuse))
    keeping = Keeping(sync_s=0.0)
    with Recorder(tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=0, keeping=keeping) as recorder:
        while not recorder.state.startswith("stopped"):
            recorder.put(nominal(1)[1][0])
            time.sleep(0.005)
        assert recorder.state == "stopped: Input/output error"


@pytest.mark.parametrize(("sync_s", "expected"), [(0.0, range(8, 60)), (100.0, range(1, 2))])
def test_a_recording_is_synced_as_often_as_it_is_told_to(sync_s, expected, disk, tmp_path):
    disk.through.set()
    keeping = Keeping(sync_s=sync_s)
    with Recorder(tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=0, keeping=keeping):
        time.sleep(0.6)
    assert disk.asked in expected  # the last one is the end's


def test_tasks_are_done_in_their_order_and_one_that_fails_says_so():
    syncer, done = Syncer(), []
    assert syncer.waits_since_s is None

    def fail() -> None:
        raise OSError(5, "Input/output error")

    first, second, third = (
        syncer.do(act) for act in (lambda: done.append(1), fail, lambda: done.append(3))
    )
    third.wait()
    assert done == [1, 3]
    assert (first.error, third.error) == (None, None)
    assert isinstance(second.error, OSError)
    assert syncer.waits_since_s is None
    syncer.end()
