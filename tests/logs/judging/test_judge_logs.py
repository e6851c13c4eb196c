"""A candidate on many logs: the same report whoever works on it, wherever the logs lie."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judge_logs import judge_logs
from reflexarc_logs.judging.log_names import named, without_place
from reflexarc_logs.judging.replay_logs import replay_logs
from reflexarc_runtime.errors import PolicyError, UsageError
from reflexarc_runtime.messages_pb2 import Decision
from support.processes import reflexarc
from support.recordings import drive, nominal
from support.rewriting import edit_decisions, rewrite
from support.staged_incidents import mark, staged


@pytest.fixture(scope="module")
def folder(policy: bytes, driven: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three whole logs and one that is cut off."""
    here = tmp_path_factory.mktemp("many") / "logs"
    (here / "deep").mkdir(parents=True)
    shutil.copy(driven, here / "drive.mcap")
    for seed in (1, 2):
        drive(here / f"deep/seed{seed}.mcap", policy, nominal(100, seed), 100)
    (here / "cut.mcap").write_bytes(driven.read_bytes()[:9000])
    return here


def call(folder: Path, candidate: Path, *words: object, cwd: Path, seed: str = "0") -> str:
    command = [sys.executable, "-m", "reflexarc", "replay", folder, "--policy", candidate, *words]
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    done = subprocess.run(
        list(map(str, command)), cwd=cwd, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 2, done.stderr
    return done.stdout


def test_the_report_is_the_same_bytes_whoever_works_on_it_wherever_the_logs_lie(
    folder, candidate_file, tmp_path
):
    limits = ("--max-flips", "5%", "--margin", "0.02", "--json")
    first = call(folder, candidate_file, *limits, "--jobs", 1, cwd=folder.parent)
    elsewhere = tmp_path / "other" / "place"
    shutil.copytree(folder, elsewhere)
    near = call(Path("place"), candidate_file, *limits, "--jobs", 3, cwd=elsewhere.parent, seed="7")
    assert near == first
    logs = [elsewhere / "cut.mcap", *elsewhere.glob("deep/*.mcap"), elsewhere / "drive.mcap"]
    for order in (logs, logs[::-1]):
        report = judge_logs(order, candidate_file, FlipLimits("5%", margin=0.02), jobs=2)
        assert json.loads(json.dumps(report.as_dict())) == json.loads(first)


def test_the_worst_log_comes_first_and_tells_the_status(folder, candidate_file):
    found = judge_logs(sorted(folder.rglob("*.mcap")), candidate_file)
    assert found.logs[0].log == "cut.mcap"
    assert found.logs[0].problem.startswith("expected a finished log, got a truncated one")
    rates = [one.rate for one in found.logs[1:]]
    assert rates == sorted(rates, reverse=True)
    assert len(set(rates)) == 3
    assert found.exit_status == 2
    whole = [folder / "drive.mcap", *folder.glob("deep/*.mcap")]
    assert judge_logs(whole, candidate_file).exit_status == 1
    assert judge_logs(whole, candidate_file, FlipLimits("100%")).exit_status == 0


def test_words_of_others_cannot_write_into_the_markdown(driven, candidate_file, tmp_path):
    evil = "|x|\n\n# now within the limits `<img src=x>"
    log = staged(driven, tmp_path / "a`b|c.mcap", {50: mark(evil)})
    lines = judge_logs([log], candidate_file).markdown().splitlines()
    assert not any(line.startswith(("#", "|x")) for line in lines)
    assert sum(line.startswith("| ") for line in lines) == 3
    told = [line for line in lines if "<img" in line]
    assert len(told) == 1
    assert told[0].startswith("- `` a`b|c.mcap ``: `` mark at tick 50")
    assert told[0].endswith("``")


def test_logs_are_named_below_the_folder_that_they_share(tmp_path):
    paths = [tmp_path / "x/b.mcap", tmp_path / "x/y/a.mcap", tmp_path / "x/../x/b.mcap"]
    assert list(named(paths)) == ["b.mcap", "y/a.mcap"]
    assert list(named(paths[:1])) == ["b.mcap"]
    assert without_place(f"{paths[0]}: damaged in {paths[0]}", paths[0]) == "damaged in b.mcap"


def test_a_policy_that_is_none_is_said_once(folder, candidate_file, tmp_path):
    (tmp_path / "none.onnx").write_bytes(b"no policy")
    with pytest.raises(PolicyError, match=r"none\.onnx: expected an ONNX model"):
        judge_logs([folder / "drive.mcap"], tmp_path / "none.onnx")
    with pytest.raises(UsageError, match="--jobs"):
        judge_logs([folder / "drive.mcap"], candidate_file, jobs=-1)


def faster(decision: Decision) -> None:
    if decision.index == 30:
        decision.command.linear_mps += 1.0


@pytest.mark.parametrize("jobs", [1, 2])
def test_without_a_candidate_the_table_is_of_this_software(folder, tmp_path, jobs):
    shutil.copytree(folder, tmp_path / "logs")
    rewrite(folder / "drive.mcap", tmp_path / "logs/wrong.mcap", edit_decisions(faster))
    found = replay_logs((tmp_path / "logs").rglob("*.mcap"), jobs=jobs)
    assert [(one.log, one.exit_status) for one in found.logs] == [
        ("cut.mcap", 2),
        ("wrong.mcap", 1),
        ("deep/seed1.mcap", 0),
        ("deep/seed2.mcap", 0),
        ("drive.mcap", 0),
    ]
    wrong = found.logs[1]
    assert wrong.said.startswith("first at tick 30, command.linear_mps: 2.0 → 1.0")
    assert wrong.compared == wrong.identical + 1
    assert found.exit_status == 2
    assert "**nothing was compared**" in found.markdown()


def test_a_single_log_without_limits_says_what_it_always_said(driven, candidate_file):
    plain = reflexarc("replay", driven, "--policy", candidate_file, "--level", "policy")
    assert plain.returncode == 1
    assert plain.stdout.startswith(f"{driven}: different\n  policy ")
    for limit, status in (("--max-flips=100%", 0), ("--max-flips=1%", 1), ("--from=5000", 2)):
        assert reflexarc("replay", driven, "--policy", candidate_file, limit).returncode == status
    alone = reflexarc("replay", driven, "--max-flips", "5%")
    assert alone.returncode == 2
    assert "limits judge a candidate: give one with --policy" in alone.stderr
