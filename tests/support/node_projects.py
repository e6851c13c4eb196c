"""A project with nodes as tests, and pytest run on it in a process of its own."""

import os
import subprocess
import sys
from pathlib import Path

ROOM = Path(__file__).parents[2]
ROOMS = [str(ROOM / folder) for folder in ("runtime", "logs")]


def write_project(folder: Path, settings: str, **modules: str) -> Path:
    """A project: what stands below `[tool.pytest.ini_options]`, and its modules by name."""
    (folder / "pyproject.toml").write_text(settings)
    for name, text in modules.items():
        path = folder / f"{name.replace('__', '/')}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return folder


def run_pytest(project: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Pytest with this plugin alone; `-n` brings xdist."""
    environment = {
        **os.environ,
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTHONPATH": os.pathsep.join(ROOMS),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    environment.pop("PYTEST_ADDOPTS", None)
    xdist = ["-p", "xdist"] * ("-n" in arguments)
    plugin = ["-p", "reflexarc_logs.pytest_plugin", "-p", "no:cacheprovider", *xdist]
    command = [sys.executable, "-m", "pytest", *plugin, "-v", *arguments]
    return subprocess.run(command, cwd=project, env=environment, capture_output=True, text=True)
