"""Asks the systemd of this machine, where one runs: systemctl(1)."""

import subprocess
from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.service.unit import BACK_OFF_SINCE

RUNS_HERE = Path("/run/systemd/system")
"""There if systemd is the first process: sd_booted(3)."""


def systemctl(*words: str) -> bool:
    """Ask for something; whether there was somebody to ask.

    Raises:
        UsageError: it was not done.
    """
    if not RUNS_HERE.is_dir():
        return False
    done = subprocess.run(["systemctl", *words], capture_output=True, text=True, check=False)
    if done.returncode:
        raise UsageError(f"systemctl {' '.join(words)}: {done.stderr.strip()[:200]}")
    return True


def systemd_version() -> int:
    """The version of the systemd on this machine; a new one where there is none."""
    words = ["systemctl", "--version"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False)
        return int(done.stdout.split()[1])
    except (OSError, ValueError, IndexError):
        return BACK_OFF_SINCE
