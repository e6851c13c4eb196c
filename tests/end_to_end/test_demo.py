"""The whole arc, as a newcomer runs it."""

import json
import subprocess
import sys
from pathlib import Path

from support.processes import reflexarc

DEMO_S = 400.0


def test_the_demo_learns_drives_and_replays_identically(tmp_path: Path):
    words = ("demo", "--json", "--seconds", "9", "--agents", "128", "--out", str(tmp_path / "demo"))
    done = subprocess.run(
        [sys.executable, "-m", "reflexarc", *words],
        capture_output=True,
        text=True,
        timeout=DEMO_S,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert {"learning", "drive", "log", "replay", "lidar"} <= set(found)
    assert found["learning"]["share_of_blind"] <= 0.35
    assert found["replay"]["verdict"] == found["lidar"]["verdict"] == "identical"
    for level in ("policy", "node"):
        compared = found["replay"]["levels"][level]
        assert compared["compared"] == compared["identical"] > 400
    assert all(Path(path).stat().st_size > 1000 for path in found["files"].values())


def test_the_demo_removes_nothing_that_it_did_not_make(tmp_path: Path):
    (tmp_path / "training").mkdir()
    (tmp_path / "training" / "mine.txt").write_text("years of work")
    done = reflexarc("demo", "--out", tmp_path)
    assert done.returncode == 2
    assert "no demo made it" in done.stderr
    assert (tmp_path / "training" / "mine.txt").read_text() == "years of work"
