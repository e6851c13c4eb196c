"""A folder takes many recordings; what earlier ones left makes room first, and nothing else."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.container.file_lock import FileLock
from reflexarc_logs.container.manifest import manifest_of, read_head, read_manifest
from reflexarc_logs.cutting.join import join
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.recording.black_box import BoxSpan
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.place import NoRoomError, Place
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.recording.shelves import claim
from reflexarc_logs.recording.shelves.claim import claimed
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from support.policies import exported
from support.recordings import CONTRACT, RUN, WALL_OFFSET_NS, drive, nominal

SECOND = Keeping(rotate_s=1.0, who="a test")
TICKS = 150


@pytest.fixture(scope="module")
def policy() -> bytes:
    return exported(CONTRACT, 3, "Relu")


@pytest.fixture
def logs(tmp_path: Path) -> Path:
    (tmp_path / "logs").mkdir()
    return tmp_path / "logs"


def record(logs: Path, policy: bytes, run_id: str, keeping: Keeping = SECOND) -> None:
    run = replace(RUN, run_id=run_id * 8)
    drive(logs, policy, nominal(TICKS), TICKS, keeping=keeping, run=run)


def names(folder: Path, pattern: str = "*") -> set[str]:
    return {path.name for path in folder.glob(pattern)}


def size_of(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.glob("*.mcap*"))


def killed(logs: Path, policy: bytes, run_id: str) -> Path:
    """What a recorder leaves that is killed in its second part; its `.partial`."""
    before = names(logs)
    record(logs, policy, run_id)
    (first,) = (logs / name for name in names(logs) - before if name.endswith(".parts.jsonl"))
    stem = first.name.removesuffix(".parts.jsonl")
    for number in range(3, 9):
        (logs / f"{stem}.part{number}.mcap").unlink(missing_ok=True)
    lines = [json.loads(line) for line in first.read_text().splitlines()]
    kept = [one for one in lines if one.get("part", 0) < 2 or one["event"] == "begun"]
    text = "\n".join(json.dumps(one) for one in kept if one.get("part", 0) < 3)
    first.write_text(text + '\n{"at": "2026')  # and in the middle of a word
    part = logs / f"{stem}.part2.mcap"
    return part.rename(part.with_name(part.name + ".partial"))


def test_each_recording_of_a_folder_has_a_name_and_a_manifest_of_its_own(policy, logs):
    for run_id in ("aaaa", "bbbb", "cccc"):
        record(logs, policy, run_id)
    manifests = sorted(names(logs, "*.parts.jsonl"), key=lambda name: read_head(logs / name).number)
    assert manifests[0] == "logs.parts.jsonl"
    assert all(name.startswith("logs_20") for name in manifests[1:])
    assert [read_head(logs / name).run_id[:4] for name in manifests] == ["aaaa", "bbbb", "cccc"]
    for name in manifests:
        parts = log_paths([logs / name])
        assert len(parts) == 3
        assert all(replay(part).exit_status == 0 for part in parts)
    assert len(log_paths([logs])) == 9
    assert join(logs / manifests[1], logs.parent / "one.mcap").ticks == TICKS + 1
    with pytest.raises(LogError, match="expected one recording, found 3"):
        join(logs, logs.parent / "other.mcap")


def test_two_starts_in_one_millisecond_have_two_names(logs, monkeypatch):
    class Stopped(claim.datetime.datetime):
        @classmethod
        def now(cls, tz=None):
            return cls(2026, 11, 30, 5, 2, 33, 123_400)

    monkeypatch.setattr(claim.datetime, "datetime", Stopped)
    held = [claimed(logs, "whole run", "id") for _ in range(4)]
    stem = "logs_2026-11-30_05-02-33.123"
    assert [one.first.name for one in held] == [
        "logs.mcap",
        f"{stem}.mcap",
        f"{stem}-2.mcap",
        f"{stem}-3.mcap",
    ]
    assert [read_head(one.manifest.path).number for one in held] == [1, 2, 3, 4]


def test_processes_that_start_at_once_have_different_names(logs):
    script = (
        "import sys; from pathlib import Path\n"
        "from reflexarc_logs.recording.shelves.claim import claimed\n"
        "sys.stdin.read(); print(claimed(Path(sys.argv[1]), 'whole run', 'id').first.name)\n"
    )
    ready, go = os.pipe()
    words = [sys.executable, "-c", script, str(logs)]
    many = [
        subprocess.Popen(words, stdin=ready, stdout=subprocess.PIPE, text=True) for _ in range(4)
    ]
    os.close(ready)
    os.close(go)
    assert len({one.communicate()[0] for one in many}) == len(many) == len(names(logs))


def test_a_folder_that_cannot_be_written_is_said(logs, monkeypatch):
    def refuse(path: Path) -> None:
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(FileLock, "made", refuse)
    with pytest.raises(LogError, match="logs: cannot be written: Read-only file system"):
        claimed(logs, "whole run", "id")


def test_what_earlier_recordings_left_makes_room_first_the_oldest_first(policy, logs):
    for run_id in ("aaaa", "bbbb"):
        record(logs, policy, run_id)
    partial = killed(logs, policy, "cccc")
    keep_bytes = round(size_of(logs) * 0.9)
    oldest = sorted(names(logs, "logs.*mcap"))
    record(logs, policy, "dddd", replace(SECOND, keep_bytes=keep_bytes))
    assert size_of(logs) <= keep_bytes
    ours = next(p for p in logs.glob("*.parts.jsonl") if read_head(p).run_id.startswith("dddd"))
    said = [json.loads(line) for line in ours.read_text().splitlines()]
    gone = [one["name"] for one in said if one["event"] == "removed before"]
    assert gone[: len(oldest)] == [oldest[0], *oldest[1:]]
    assert not any((logs / name).exists() for name in gone)
    assert partial.exists()
    assert [one["name"] for one in said if one["event"] == "forgotten"] == ["logs.parts.jsonl"]
    assert all(part.state == "finished" for part in read_manifest(ours))


def test_a_killed_recording_s_partial_goes_in_its_turn(policy, logs):
    partial = killed(logs, policy, "aaaa")
    record(logs, policy, "bbbb")
    keep_bytes = size_of(logs)
    record(logs, policy, "cccc", replace(SECOND, keep_bytes=keep_bytes))
    assert not partial.exists()
    assert not (logs / "logs.parts.jsonl").exists()
    assert len([n for n in names(logs, "*.mcap") if n.startswith("logs_")]) >= 3


def test_of_one_of_which_something_is_left_the_manifest_says_what_went(policy, logs):
    partial = killed(logs, policy, "aaaa")
    keep_bytes = size_of(logs) + 1 - (logs / "logs.mcap").stat().st_size // 2
    with Recorder(logs, RUN, policy, {}, wall_offset_ns=0, keeping=Keeping(keep_bytes=keep_bytes)):
        pass
    first, second = read_manifest(logs / "logs.parts.jsonl")
    assert (first.state, second.state, partial.exists()) == ("removed", "begun", True)
    assert first.why.startswith("all parts had more than")


def everything_must_go(logs: Path, policy: bytes) -> None:
    """A recording that may keep nothing of others."""
    with Recorder(logs, RUN, policy, {}, wall_offset_ns=0, keeping=Keeping(keep_bytes=1)):
        pass


def test_a_living_process_keeps_its_files(policy, logs):
    living = Recorder(logs, RUN, policy, {}, wall_offset_ns=WALL_OFFSET_NS, keeping=SECOND)
    with living:
        everything_must_go(logs, policy)
        assert (logs / "logs.mcap.partial").exists()
        assert read_head(logs / "logs.parts.jsonl").number == 1
    assert (logs / "logs.mcap").exists()


@pytest.mark.parametrize("of", ["another run", "another part", "another size", "no log", "a link"])
def test_what_is_not_ours_stays_whatever_its_name(of, policy, logs, tmp_path):
    record(logs, policy, "aaaa")
    victim = logs / "logs.part2.mcap"
    if of == "another run":
        partial = killed(logs, policy, "bbbb")
        shutil.copyfile(victim, partial)
        victim = partial
    elif of == "another part":
        partial = killed(logs, policy, "bbbb")
        shutil.copyfile(next(logs.glob("logs_*[0-9].mcap")), partial)
        victim = partial
    elif of == "another size":
        victim.write_bytes(victim.read_bytes() + b"\0")
    elif of == "no log":
        (logs / "logs.part3.mcap.partial").write_text("my notes")
        victim = logs / "logs.part3.mcap.partial"
    else:
        precious = victim.rename(tmp_path / "precious.mcap")
        victim.symlink_to(precious)
    kept = victim.read_bytes()
    (logs / "named.mcap").write_bytes(b"nobody names it")
    everything_must_go(logs, policy)
    assert victim.read_bytes() == kept
    assert (logs / "named.mcap").exists()
    left = names(logs, "*.mcap*") - {victim.name, "named.mcap"}
    assert all(read_head(manifest_of(logs / name)).run_id == RUN.run_id for name in left)


def test_a_recording_that_was_given_a_name_is_nobody_s_to_remove(policy, logs):
    drive(logs / "mine.mcap", policy, nominal(60), 60, keeping=SECOND)
    before = names(logs)
    everything_must_go(logs, policy)
    assert before <= names(logs)


def test_a_black_box_and_whole_runs_do_not_remove_each_other_s(policy, logs):
    record(logs, policy, "aaaa")
    before = names(logs)
    keeping = Keeping(keep_bytes=1)
    box = BoxSpan(1.0)
    with Recorder(logs, RUN, policy, {}, wall_offset_ns=0, keeping=keeping, box=box):
        pass
    assert names(logs) == before  # and a box that wrote nothing leaves nothing


def test_what_somebody_recovered_is_kept_as_long_as_the_part_would_be(policy, logs):
    partial = killed(logs, policy, "aaaa")
    recover(partial, partial.with_suffix(""))
    everything_must_go(logs, policy)
    assert not partial.exists()
    assert not partial.with_suffix("").exists()


def test_without_locks_nothing_of_others_is_removed(policy, logs, monkeypatch):
    def no_locks(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("fcntl.flock", no_locks)
    record(logs, policy, "aaaa")
    monkeypatch.undo()
    before = names(logs)
    record(logs, policy, "bbbb")
    everything_must_go(logs, policy)
    assert before <= names(logs)
    assert len([p for p in logs.glob("*.parts.jsonl") if read_head(p).folder]) == 1


def test_what_is_not_ours_does_not_count_either(policy, logs):
    partial = killed(logs, policy, "aaaa")
    keep_bytes = size_of(logs)
    partial.write_bytes(bytes(10 * keep_bytes))
    with Recorder(logs, RUN, policy, {}, wall_offset_ns=0, keeping=Keeping(keep_bytes=keep_bytes)):
        pass
    assert (logs / "logs.mcap").exists()


def test_a_recording_that_could_not_begin_leaves_no_name_behind(policy, logs, monkeypatch):
    def full(place: Place) -> None:
        raise NoRoomError("the disk is full")

    monkeypatch.setattr(Place, "check_room", full)
    with pytest.raises(LogError, match="the disk is full"):
        Recorder(logs, RUN, policy, {}, wall_offset_ns=0, keeping=SECOND)
    assert names(logs) == set()


def test_room_is_made_before_the_first_part_is_begun(policy, logs, monkeypatch):
    """Else a disk that earlier recordings filled refuses every start."""
    record(logs, policy, "aaaa")

    def full(place: Place) -> None:
        if (logs / "logs.mcap").exists():
            raise NoRoomError("the disk is full")

    monkeypatch.setattr(Place, "check_room", full)
    everything_must_go(logs, policy)
