"""The parts of a recording become the log that a recording in one piece would have been."""

import dataclasses
import json
import shutil
from collections import Counter
from pathlib import Path

import pytest
from mcap.reader import NonSeekingReader

from reflexarc_logs.cutting.join import JOINED, join
from reflexarc_logs.diffing.diff import diff
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.part import PART
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from support.policies import exported
from support.processes import reflexarc
from support.recordings import CONTRACT, RUN, drive, nominal

TICKS = 450


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One drive twice: in one piece, and in parts of a second."""
    folder = tmp_path_factory.mktemp("recorded")
    policy = exported(CONTRACT, 3, "Relu")
    drive(folder / "whole.mcap", policy, nominal(TICKS), TICKS)
    (folder / "parts").mkdir()
    keeping = Keeping(rotate_s=0.8)
    drive(folder / "parts" / "a.mcap", policy, nominal(TICKS), TICKS, keeping=keeping)
    return folder


@pytest.fixture
def parts(recorded: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(recorded / "parts", tmp_path / "parts"))


def numbers(path: Path) -> list[int]:
    return [tick.decision.index for tick in read_log(path).ticks()]


def test_the_whole_is_what_one_recording_is(recorded: Path, parts: Path, tmp_path: Path):
    assert len(list(parts.glob("*.mcap"))) >= 5
    found = join(parts, tmp_path / "one.mcap")
    assert (found.gaps, found.ticks) == ((), TICKS + 1)
    assert diff(recorded / "whole.mcap", found.path).exit_status == 0
    report = replay(found.path)
    assert (report.exit_status, [level.compared for level in report.levels]) == (
        0,
        [level.compared for level in replay(recorded / "whole.mcap").levels],
    )
    with found.path.open("rb") as file:
        counts = Counter(c.topic for _, c, _ in NonSeekingReader(file).iter_messages())
    assert sum(counts.values()) == found.messages
    one = read_log(found.path)
    assert one.run == read_log(recorded / "whole.mcap").run
    assert PART not in one.metadata
    assert one.metadata[JOINED]["missing"] == ""


def test_the_manifest_says_the_order_and_not_the_names(parts: Path, tmp_path: Path):
    """Parts are renamed as somebody might, in the manifest as well."""
    manifest = parts / "a.parts.jsonl"
    text = manifest.read_text()
    for old, new in (("a.part2.mcap", "z.mcap"), ("a.part3.mcap", "b.mcap")):
        (parts / old).rename(parts / new)
        text = text.replace(old, new)
    manifest.write_text(text)
    found = join(manifest, tmp_path / "one.mcap")
    assert found.parts[1:3] == ("z.mcap", "b.mcap")
    assert numbers(found.path) == list(range(TICKS + 1))


def test_a_lost_part_is_named_and_what_is_there_replays(parts: Path, tmp_path: Path):
    lost = numbers(parts / "a.part3.mcap")
    (parts / "a.part3.mcap").unlink()
    found = join(parts, tmp_path / "one.mcap")
    assert found.gaps == (
        "part 3, a.part3.mcap, not there",
        f"ticks {lost[0]} to {lost[-1]}, between a.part2.mcap and a.part4.mcap",
    )
    assert replay(found.path).exit_status == 0
    assert read_log(found.path).metadata[JOINED]["missing"] == "; ".join(found.gaps)


def test_a_copy_of_a_part_is_refused_and_nothing_is_left(parts: Path, tmp_path: Path):
    shutil.copyfile(parts / "a.part2.mcap", parts / "a.part3.mcap")
    with pytest.raises(LogError, match=r"a\.part3\.mcap: expected part 3 .* it is part 2"):
        join(parts, tmp_path / "one.mcap")
    shutil.copyfile(parts / "a.mcap", parts / "a.part3.mcap")  # says no number
    with pytest.raises(LogError, match=r"which stands in a\.part2\.mcap as well"):
        join(parts, tmp_path / "one.mcap")
    assert [path.name for path in tmp_path.iterdir()] == ["parts"]


def test_a_part_of_another_run_is_refused(parts: Path, tmp_path: Path):
    other = dataclasses.replace(RUN, run_id="0b5e" * 8)
    (parts / "a.part4.mcap").unlink()
    drive(parts / "a.part4.mcap", exported(CONTRACT, 3, "Relu"), nominal(50), 50, run=other)
    with pytest.raises(LogError, match="expected a part of the run 5eed5eed5eed"):
        join(parts, tmp_path / "one.mcap")


def test_places_that_are_no_recording(parts: Path, tmp_path: Path):
    with pytest.raises(LogError, match="expected a manifest"):
        join(tmp_path, tmp_path / "one.mcap")
    with pytest.raises(LogError, match="expected a recording's folder or its manifest"):
        join(parts / "a.mcap", tmp_path / "one.mcap")
    shutil.copyfile(parts / "a.parts.jsonl", parts / "b.parts.jsonl")
    with pytest.raises(LogError, match=r"found 2: name one of a\.parts\.jsonl, b\.parts\.jsonl"):
        join(parts, tmp_path / "one.mcap")


def test_the_commands_take_the_folder_as_one_log(parts: Path, tmp_path: Path):
    joined = reflexarc("join", parts, "-o", tmp_path / "one.mcap", "--json")
    assert (joined.returncode, json.loads(joined.stdout)["replay"]) == (0, "identical")
    cut = reflexarc("cut", parts, "--from", "30", "--to", "120", "-o", tmp_path / "part.mcap")
    assert (cut.returncode, numbers(tmp_path / "part.mcap")) == (0, list(range(30, 120)))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.mcap", "part.mcap", "parts"]
    listed = reflexarc("incident", parts / "a.parts.jsonl")
    assert (listed.returncode, listed.stdout.splitlines()[0][:15]) == (0, "nothing happene")
    for words in (("diff", parts, tmp_path / "one.mcap"), ("info", parts)):
        refused = reflexarc(*words)
        assert refused.returncode == 2
        assert "got a folder; of a recording in parts `reflexarc join" in refused.stderr
