"""Parts that are begun because one is full: nothing is lost between them, each replays by itself,
and the oldest make room; of others' files none is touched.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.container import unfinished
from reflexarc_logs.container import writing as log_file
from reflexarc_logs.container.first_look import look
from reflexarc_logs.container.manifest import read_manifest
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.recording import scribe as scribe_module
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.part import PART
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.recording.shelves.shelf import Shelf
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from support.bad_disks import Disks, full_after
from support.policies import exported
from support.recordings import CONTRACT, RUN, WALL_OFFSET_NS, drive, faults, nominal

TICKS = 600
"""Twelve seconds."""


@pytest.fixture(scope="module")
def policy() -> bytes:
    return exported(CONTRACT, 3, "Relu")


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    monkeypatch.setattr(log_file, "CHUNK_BYTES", 4096)


def ticks_of(path: Path) -> list[int]:
    return [tick.decision.index for tick in read_log(path).ticks()]


def inputs_of(paths: Iterator[Path]) -> list[tuple[str, int, bytes]]:
    return [
        (r.topic, r.log_ns, r.payload)
        for path in paths
        for r in read_log(path).records()
        if not r.topic.endswith("/keyframe")
    ]


def test_parts_by_time_hold_together_what_one_log_holds_and_each_replays(policy, tmp_path):
    drive(tmp_path / "whole.mcap", policy, faults(TICKS), TICKS)
    drive(tmp_path / "a.mcap", policy, faults(TICKS), TICKS, keeping=Keeping(rotate_s=3.0))
    parts = log_paths([tmp_path / "a.parts.jsonl"])
    assert [p.name for p in parts] == ["a.mcap", *(f"a.part{n}.mcap" for n in (2, 3, 4))]
    assert inputs_of(parts) == inputs_of([tmp_path / "whole.mcap"])
    assert [len(ticks_of(part)) for part in parts] == [150, 150, 150, 151]
    for part in parts:
        report = replay(part)
        assert report.exit_status == 0
        assert [(lv.level, lv.ticks) for lv in report.levels][1] == ("node", len(ticks_of(part)))
        assert next(read_log(part).records()).topic == "/robot0/keyframe"
    assert look(parts[1]).metadata[PART] == {
        "part": "2",
        "of": "a.mcap",
        "after": "3 s",
        "lost": "0",
    }


def test_parts_by_size_are_a_little_larger_than_that(policy, tmp_path, monkeypatch):
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.0)  # a size is known once it is flushed
    limit = 50_000
    drive(tmp_path / "a.mcap", policy, nominal(TICKS), TICKS, keeping=Keeping(rotate_bytes=limit))
    *full, last = log_paths([tmp_path])
    assert len(full) >= 2
    assert last.stat().st_size < 3 * limit
    assert all(limit <= p.stat().st_size < 3 * limit for p in full)  # a keyframe is a second apart
    assert sorted(i for p in (*full, last) for i in ticks_of(p)) == list(range(TICKS + 1))


def test_the_oldest_make_room_and_the_manifest_says_who_removed_what_when(policy, tmp_path):
    (tmp_path / "a.part3.mcap").write_bytes(b"somebody else's")
    keeping = Keeping(rotate_s=1.0, keep_bytes=120_000, who="a test")
    drive(tmp_path / "a.mcap", policy, nominal(TICKS), TICKS, keeping=keeping)
    listed = read_manifest(tmp_path / "a.parts.jsonl")
    assert [part.number for part in listed] == [1, 2, *range(4, 14)]  # a name was taken
    gone = [part for part in listed if part.state == "removed"]
    kept = [part for part in listed if part.state == "finished"]
    assert (*gone, *kept) == listed  # the oldest are gone
    assert gone
    assert not any(part.path.exists() for part in gone)
    assert 60_000 < sum(part.path.stat().st_size for part in kept) <= 120_000
    assert all(replay(part.path).exit_status == 0 for part in kept)
    assert (tmp_path / "a.part3.mcap").read_bytes() == b"somebody else's"
    lines = [json.loads(x) for x in (tmp_path / "a.parts.jsonl").read_text().splitlines()]
    removed = [line for line in lines if line["event"] == "removed"]
    assert {(line["by"], line["why"]) for line in removed} == {
        ("a test", "all parts had more than 0.114441 MB")
    }
    assert [line["at"] for line in lines] == sorted(line["at"] for line in lines)


def shelved(tmp_path: Path) -> tuple[Shelf, list[Path]]:
    """Three parts of 10 bytes each."""
    shelf = Shelf(tmp_path / "a.mcap", Keeping(keep_bytes=25, who="a test"), "id")
    paths = [tmp_path / name for name in ("a.mcap", "a.part2.mcap", "a.part3.mcap")]
    for number, path in enumerate(paths, 1):
        shelf.begun(number, path, "")
        path.write_bytes(b"0123456789")
        shelf.ended(number, path, path)
    return shelf, paths


def test_a_file_that_took_the_name_of_a_part_is_left_alone(tmp_path):
    shelf, (first, second, third) = shelved(tmp_path)
    first.rename(tmp_path / "kept.mcap")
    first.write_bytes(b"precious")
    second.unlink()
    shelf.make_room(current_bytes=20)
    assert first.read_bytes() == b"precious"
    assert (tmp_path / "kept.mcap").exists()
    assert not third.exists()
    listed = read_manifest(tmp_path / "a.parts.jsonl")
    assert [(part.state, part.why) for part in listed] == [
        ("left", "another file has its name"),
        ("left", "somebody removed or renamed it before"),
        ("removed", "all parts had more than 2.38419e-05 MB"),
    ]


def test_no_more_is_removed_than_must_be(tmp_path):
    shelf, paths = shelved(tmp_path)
    shelf.make_room(current_bytes=5)
    assert [path.exists() for path in paths] == [False, True, True]


def test_parts_of_another_recording_are_refused_before_anything_is_written(tmp_path):
    (tmp_path / "a.parts.jsonl").write_text("")
    with pytest.raises(LogError, match=r"a\.parts\.jsonl: parts of another recording are there"):
        Recorder(tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=0, keeping=Keeping(rotate_s=1.0))
    assert [path.name for path in tmp_path.iterdir()] == ["a.parts.jsonl"]


def test_a_recording_in_one_piece_has_no_manifest(policy, tmp_path):
    drive(tmp_path / "a.mcap", policy, nominal(60), 60)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mcap"]


def test_a_listener_s_parts_begin_with_whatever_comes(tmp_path):
    run = replace(RUN, recorded_by="record")
    keeping = Keeping(rotate_s=2.0)
    path = tmp_path / "a.mcap"
    with Recorder(path, run, b"", {}, wall_offset_ns=WALL_OFFSET_NS, keeping=keeping) as recorder:
        for batch in nominal(300).values():
            for message in batch:
                recorder.put(message)
    counts = [len(list(read_log(part).records())) for part in recorder.parts]
    assert counts == [100, 100, 100]
    assert not recorder.failed


def test_a_disk_that_fails_amid_parts_goes_on_as_ever(policy, tmp_path, monkeypatch):
    monkeypatch.setattr("reflexarc_logs.recording.series.RETRY_S", 0.0)
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.01)
    monkeypatch.setattr(
        unfinished, "open_for_writing", Disks(full_after(1 << 20), full_after(8_000))
    )
    drive(tmp_path / "a.mcap", policy, nominal(TICKS), TICKS, keeping=Keeping(rotate_s=3.0))
    listed = read_manifest(tmp_path / "a.parts.jsonl")
    assert [part.state for part in listed[:2]] == ["finished", "failed"]
    assert all(part.state == "finished" for part in listed[2:])
    full = "No space left on device"
    assert [part.why for part in listed[:3]] == ["", full, full]
    assert all(replay(part).exit_status == 0 for part in log_paths([tmp_path / "a.parts.jsonl"]))
