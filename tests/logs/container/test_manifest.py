"""A manifest is read as it was written, whatever a kill or another version left in it."""

import json
from pathlib import Path

import pytest

from reflexarc_logs.container.manifest import Manifest, manifest_of, read_manifest
from reflexarc_runtime.errors import LogError


def written(folder: Path) -> Path:
    manifest = Manifest(folder / "a.mcap", "id")
    manifest.say("begun", part=1, name="a.mcap")
    assert not manifest.path.exists()  # until somebody begins it
    manifest.begin()
    manifest.say("finished", part=1, name="a.mcap", bytes=7)
    manifest.say("begun", part=2, name="a.part2.mcap", after="60 s")
    return manifest.path


def test_it_stands_beside_its_parts():
    assert manifest_of(Path("runs/a.b.mcap")) == Path("runs/a.b.parts.jsonl")


def test_every_part_is_as_it_was_said_last(tmp_path):
    listed = read_manifest(written(tmp_path))
    assert [(p.number, p.path.name, p.state, p.why) for p in listed] == [
        (1, "a.mcap", "finished", ""),
        (2, "a.part2.mcap", "begun", "60 s"),
    ]


@pytest.mark.parametrize("kept", [1, 10, 60])
def test_a_last_line_that_was_cut_off_by_a_kill_is_left_out(tmp_path, kept):
    path = written(tmp_path)
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:-1]) + lines[-1][:kept])
    assert [part.number for part in read_manifest(path)] == [1]


def test_events_and_fields_of_a_newer_version_are_left_alone(tmp_path):
    path = written(tmp_path)
    with path.open("a") as file:
        file.write(json.dumps({"event": "polished", "by": "whom"}) + "\n")
    assert len(read_manifest(path)) == 2


def test_a_second_recording_of_the_same_name_begins_anew(tmp_path):
    written(tmp_path)
    assert len(read_manifest(written_again(tmp_path))) == 1


def written_again(folder: Path) -> Path:
    manifest = Manifest(folder / "a.mcap", "other")
    manifest.begin()
    manifest.say("begun", part=1, name="a.mcap")
    return manifest.path


@pytest.mark.parametrize(
    "line",
    [
        "no json",
        "[]",
        "[" * 100_000,
        '{"event": "begun", "part": 1e999, "name": "a.mcap"}',
        '{"event": "begun"}',
        '{"event": "begun", "part": "x", "name": "a.mcap"}',
        '{"event": "finished", "part": 1, "name": "../../etc/passwd"}',
        '{"event": "finished", "part": 1, "name": "/etc/passwd"}',
        '{"event": ["begun"], "part": 1, "name": "a.mcap"}',
    ],
)
def test_what_is_no_event_is_refused_with_its_line(tmp_path, line):
    path = written(tmp_path)
    with path.open("a") as file:
        file.write(line + "\n")
    with pytest.raises(LogError, match=r"a\.parts\.jsonl, line 5: expected"):
        read_manifest(path)
