"""A new baseline: the decisions of now stand where the old ones did, and all else is the same."""

import hashlib
import shutil
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.reader import NonSeekingReader

from reflexarc_logs.cutting.incident_part import choose, cut_incident
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.testing.baseline import accept
from reflexarc_logs.testing.baseline_file import BASELINE
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported
from support.recordings import CONTRACT, FAULT_STALLS, RUN, drive, faults, nominal
from support.remembering import remembering_policy
from support.remembering_drives import drive_remembering
from support.rewriting import edit_decisions, rewrite

TICKS = 300


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("driven") / "drive.mcap"
    drive(path, exported(CONTRACT, 3, "Relu"), faults(TICKS), TICKS, stalls=FAULT_STALLS)
    return path


@pytest.fixture
def log(driven: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(driven, tmp_path / "log.mcap"))


@pytest.fixture(scope="module")
def candidate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("candidate") / "candidate.onnx"
    path.write_bytes(exported(CONTRACT, 4, "Relu"))
    return path


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def received(path: Path) -> list[tuple[str, int, int, int, bytes]]:
    """All messages that are no decisions, with all that stands beside them."""
    decided = {"reflexarc.Tick", "reflexarc.Command", "reflexarc.Keyframe"}
    with path.open("rb") as file:
        return [
            (
                c.topic,
                m.sequence,
                m.log_time,
                m.publish_time,
                m.data if s.name not in decided else b"",
            )
            for s, c, m in NonSeekingReader(file).iter_messages(log_time_order=False)
        ]


def test_a_log_that_replays_is_left_alone(log):
    before = sha256(log)
    assert accept(log, None) is None
    assert sha256(log) == before


def test_a_candidate_becomes_the_policy_of_the_log_as_if_it_had_driven(
    log, driven, candidate, tmp_path
):
    found = accept(log, candidate)
    assert found is not None
    assert (found.old_sha256, found.new_sha256) == (sha256(driven), sha256(log))
    assert found.new_policy == load_policy(candidate).policy_hash
    assert received(log) == received(driven)
    drive(tmp_path / "own.mcap", candidate.read_bytes(), faults(TICKS), TICKS, stalls=FAULT_STALLS)
    theirs = [tick.decision for tick in read_log(tmp_path / "own.mcap").ticks()]
    assert [tick.decision for tick in read_log(log).ticks()] == theirs  # here nothing is moved
    report = replay(log)
    assert report.exit_status == 0
    assert [level.level for level in report.levels] == ["policy", "node"]
    assert report.commands[0].identical == TICKS + 1
    assert read_log(log).metadata[BASELINE]["of"] == sha256(driven)
    assert accept(log, candidate) is None
    assert sorted(log.parent.iterdir()) == [log, tmp_path / "own.mcap"]


def test_old_and_new_are_shown_with_the_difference_in_words(log, driven, candidate):
    olds = [tick.decision for tick in read_log(log).ticks()]
    found = accept(log, candidate)
    assert found is not None
    news = [tick.decision for tick in read_log(log).ticks()]
    other = sum(a.winner != b.winner for a, b in zip(olds, news, strict=True))
    asked = sum(bool(a.q_values) for a in olds)
    first = next(a.index for a in olds if a.q_values)
    assert f"{asked} of {TICKS + 1} ticks are decided otherwise" in found.said
    assert f"at {other} another action is preferred" in found.said
    assert f"first at tick {first}, q_values[0]: " in found.said
    assert found.lines()[1] == f"  old: sha256 {sha256(driven)}, policy {found.old_policy[:12]}"


def test_what_the_software_decides_now_takes_the_place_of_what_it_decided(log, driven, tmp_path):
    def turned(decision: Decision) -> None:
        if decision.index in (30, 31):
            decision.action = (decision.action + 1) % 3

    changed = rewrite(log, tmp_path / "changed.mcap", edit_decisions(turned))
    assert replay(changed).exit_status == 1
    found = accept(changed, None)
    assert found is not None
    assert found.said.startswith(f"2 of {TICKS + 1} ticks are decided otherwise; at 2 another one")
    ticks = [tick.decision for tick in read_log(changed).ticks()]
    assert ticks == [tick.decision for tick in read_log(driven).ticks()]


def test_a_memory_is_carried_on_as_if_the_candidate_had_driven(tmp_path):
    log, own = (drive_remembering(tmp_path / f"{seed}.mcap", seed) for seed in (0, 1))
    candidate = tmp_path / "candidate.onnx"
    candidate.write_bytes(remembering_policy(1))
    assert accept(log, candidate) is not None
    decided = [tick.decision for tick in read_log(log).ticks()]
    assert decided == [tick.decision for tick in read_log(own).ticks()]
    assert replay(log).exit_status == 0


@pytest.mark.parametrize("kind", ["guard", "slice"])
def test_guards_and_parts_are_carried_on(kind, log, candidate, tmp_path):
    if kind == "guard":
        guarded = replace(RUN, guard=GuardSettings.of(CONTRACT).to_json())
        log = tmp_path / "guarded.mcap"
        drive(log, exported(CONTRACT, 3, "Relu"), nominal(100), 100, run=guarded)
    else:
        whole = read_log(log)
        part = cut_incident(whole, choose(whole, 120, None), 1.0, tmp_path / "part.mcap")
        log = part.part.path
    assert accept(log, candidate) is not None
    report = replay(log)
    assert (report.exit_status, report.same_policy) == (0, True)
    assert [level.level for level in report.levels] == ["policy", "node"]


def test_what_cannot_be_decided_anew_stays_as_it_was(log, candidate, tmp_path):
    def without_one(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic.endswith("/retina") and nth == 90 else payload

    holed = rewrite(log, tmp_path / "holed.mcap", without_one)
    before = sha256(holed)
    with pytest.raises(LogError, match="ticks or inputs are missing before tick"):
        accept(holed, candidate)
    assert sha256(holed) == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["holed.mcap", "log.mcap"]


def test_a_link_keeps_leading_to_the_log_that_is_replaced(log, candidate, tmp_path):
    link = tmp_path / "link.mcap"
    link.symlink_to("log.mcap")
    log.chmod(0o640)
    assert accept(link, candidate) is not None
    assert link.is_symlink()
    assert replay(log, policy=candidate).same_policy
    assert log.stat().st_mode & 0o777 == 0o640
