"""Replay and diff are no empty check: a small run of the campaign of changes."""

import subprocess
import sys
from pathlib import Path

CAMPAIGN = Path(__file__).parents[1] / "campaigns" / "mutations.py"


def test_each_of_forty_changes_is_found_and_named():
    ended = subprocess.run(
        [sys.executable, CAMPAIGN, "--count", "40", "--seed", "7"],
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout + ended.stderr
    assert "40 changes" in ended.stdout
    assert "0 missed" in ended.stdout
