"""`reflexarc study` with real processes, which are killed in the middle."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.study.unit import Unit
from support.processes import PATIENCE_S, Process, finished, reflexarc, started, wait_until

CELLS, SEEDS = 2, 5
UNITS = CELLS * SEEDS

STUDY = f"""\
title = "Nothing in particular"
question = "Does it end?"
preset = "online"
seeds = {SEEDS}
steps = 40000

[evaluation]
agents = 16
steps = 100

[[axis]]
label = "γ"
field = "learner.gamma"
values = [0.8, 0.9]
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("study")
    (path / "mine.toml").write_text(STUDY)
    return path


@pytest.fixture(scope="module")
def alone(folder: Path) -> dict[str, Any]:
    """The results of one process after another."""
    done = reflexarc("study", "mine.toml", "--jobs", 1, "-o", "alone", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["done"] == UNITS
    return figures(folder / "alone")


def lines(out: Path) -> list[dict[str, Any]]:
    file = out / "results.jsonl"
    whole = file.read_bytes().split(b"\n")[:-1] if file.exists() else []
    return [json.loads(line) for line in whole]


def figures(out: Path) -> dict[str, Any]:
    """By unit, all but the times."""
    return {
        line["unit"]: {k: v for k, v in line.items() if not k.endswith("_s")} for line in lines(out)
    }


def workers(process: Process) -> list[int]:
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    return [int(pid) for pid in children]


def is_gone(pid: int) -> bool:
    """Whether a process has ended; one that nobody has waited for yet has."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


def study(folder: Path, out: str, jobs: int = 2) -> Any:
    words = ("study", "mine.toml", "--jobs", jobs, "-o", out, "--json")
    return started(*words, cwd=folder)


@pytest.fixture
def orphans() -> Iterator[list[int]]:
    """Workers whose parent a test kills: whatever happens, they do not outlive it."""
    pids: list[int] = []
    yield pids
    for pid in pids:
        if not is_gone(pid):
            os.kill(pid, signal.SIGKILL)


@pytest.mark.long
def test_killed_worker_is_replaced_and_no_result_is_lost(
    folder: Path, alone: dict[str, Any]
) -> None:
    out = folder / "worker"
    with study(folder, "worker") as process:
        wait_until(lambda: lines(out), "a first result")
        os.kill(workers(process)[0], signal.SIGKILL)
        result = finished(process)
    assert (result["done"], result["failed"], result["interrupted"]) == (UNITS, [], False)
    assert len(lines(out)) == UNITS
    assert figures(out) == alone  # and two processes give what one gave
    assert (out / "study.md").exists()
    assert (out / "study.png").exists()


@pytest.mark.long
def test_study_goes_on_where_it_was_killed_or_interrupted(
    folder: Path, alone: dict[str, Any], orphans: list[int]
) -> None:
    out = folder / "parent"
    with study(folder, "parent") as process:
        wait_until(lambda: len(lines(out)) >= 2, "two results")
        orphans += workers(process)
        process.kill()
        process.wait()
    assert orphans
    wait_until(lambda: all(map(is_gone, orphans)), "its processes ended with it", 20.0)
    kept = (out / "results.jsonl").read_bytes()
    (out / "results.jsonl").write_bytes(kept + kept[:40])  # as if it had died while writing
    before = len(lines(out))
    with study(folder, "parent", jobs=1) as process:
        wait_until(lambda: len(lines(out)) > before, "one more result")
        children = workers(process)
        process.send_signal(signal.SIGINT)
        said, complaint = process.communicate(timeout=60.0)
    assert process.returncode == 0
    assert json.loads(said)["interrupted"]
    assert "interrupted; go on with: reflexarc study mine.toml -o parent" in " ".join(
        complaint.split()
    )
    assert all(map(is_gone, children))
    done = reflexarc("study", "mine.toml", "--jobs", 2, "-o", "parent", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    assert (out / "results.jsonl").read_bytes().startswith(kept)
    assert len(lines(out)) == UNITS  # nothing was done twice
    assert figures(out) == alone


def test_worker_ends_with_its_input_amid_its_work() -> None:
    long = Unit(TrainConfig(steps=10**12))
    worker = subprocess.Popen(
        [sys.executable, "-m", "reflexarc_trainer.study.worker"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert worker.stdin is not None
    assert worker.stdout is not None
    try:
        assert "ready" in json.loads(worker.stdout.readline())
        worker.stdin.write(json.dumps(long.to_plain()) + "\n")
        worker.stdin.close()
        assert worker.wait(PATIENCE_S) == 0
    finally:
        worker.kill()
        worker.wait()
        worker.stdout.close()
