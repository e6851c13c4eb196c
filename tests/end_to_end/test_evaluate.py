"""`reflexarc evaluate --suite` with real processes, killed in the middle."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.processes import reflexarc, started, wait_until
from support.small_suite import write_small_suite

WHO = ("--controller", "small_controllers.py:Mine", "small_controllers.py:Gambler")
SUITE = ("evaluate", *WHO, "--suite", "./small.toml", "--json")


def whole_lines(out: Path) -> int:
    file = out / "rows.jsonl"
    return file.read_bytes().count(b"\n") if file.exists() else 0


def children_of(pid: int) -> list[int]:
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def is_gone(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except OSError:
        return True


@pytest.fixture
def orphans() -> Iterator[list[int]]:
    """Workers whose parent is killed: whatever happens, they do not outlive the test."""
    pids: list[int] = []
    yield pids
    for pid in pids:
        if not is_gone(pid):
            os.kill(pid, signal.SIGKILL)


@pytest.mark.long
def test_suite_that_was_killed_or_interrupted_goes_on_to_the_same_bytes(
    tmp_path: Path, orphans: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    suite, _ = write_small_suite(tmp_path)
    suite.write_text(suite.read_text().replace("free_paths = 3", "free_paths = 30"))
    monkeypatch.setenv("PYTHONHASHSEED", "1")
    alone = reflexarc(*SUITE, "--jobs", 3, "-o", "alone", cwd=tmp_path)
    assert alone.returncode == 0, alone.stderr
    total = whole_lines(tmp_path / "alone")

    out = tmp_path / "out"
    monkeypatch.setenv("PYTHONHASHSEED", "2")
    with started(*SUITE, "--jobs", 1, "-o", "out", cwd=tmp_path) as process:
        wait_until(lambda: whole_lines(out) >= 2, "two units")
        orphans += children_of(process.pid)
        process.kill()
        process.wait()
    wait_until(lambda: all(map(is_gone, orphans)), "its processes ended with it", 20.0)
    kept = (out / "rows.jsonl").read_bytes()
    assert 2 <= whole_lines(out) < total
    (out / "rows.jsonl").write_bytes(kept + kept[:40])  # as if it had died while writing
    before = whole_lines(out)

    with started(*SUITE, "--jobs", 1, "-o", "out", "--resume", cwd=tmp_path) as process:
        wait_until(lambda: whole_lines(out) > before, "one more unit")
        children = children_of(process.pid)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=60.0)
    assert process.returncode == 130
    assert "interrupted; what is done is kept in out: --resume goes on" in " ".join(
        complaint.split()
    )
    assert all(map(is_gone, children))

    done = reflexarc(*SUITE, "--jobs", 2, "-o", "out", "--resume", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert whole_lines(out) == total  # nothing was done twice
    assert (out / "rows.jsonl").read_bytes().startswith(kept)
    mine, theirs = (tmp_path / name / "results.json" for name in ("out", "alone"))
    assert mine.read_bytes() == theirs.read_bytes()
