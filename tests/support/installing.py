"""Services that a test installs, into a folder of its own."""

import os
import pwd
from pathlib import Path

from reflexarc.main import main

ME = pwd.getpwuid(os.getuid()).pw_name


def installed(config: Path, units: Path, *words: str) -> int:
    """As this user, who may read the folders of tests."""
    return main(["service", "install", str(config), "--units", str(units), "--user", ME, *words])
