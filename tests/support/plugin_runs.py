"""Pytest with the plugin of logs, in projects and processes of their own."""

import os
import subprocess
import sys
from pathlib import Path

ROOM = Path(__file__).parents[2]
ROOMS = [str(ROOM / folder) for folder in ("runtime", "logs")]


def run_pytest(project: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Pytest with this plugin alone, in a process and a project of its own."""
    environment = {
        **os.environ,
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTHONPATH": os.pathsep.join(ROOMS),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    environment.pop("PYTEST_ADDOPTS", None)
    plugin = ["-p", "reflexarc_logs.pytest_plugin", "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *plugin, "-v", *arguments]
    return subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True)


def project(directory: Path, options: str) -> Path:
    (directory / "pytest.ini").write_text(f"[pytest]\nfilterwarnings = error\n{options}\n")
    (directory / "golden").mkdir()
    return directory
