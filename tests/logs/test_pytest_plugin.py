import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from reflexarc_runtime.messages_pb2 import Decision
from support.rewriting import edit_decisions, rewrite

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


@pytest.fixture(scope="module")
def outcome(log_path: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """What pytest says of a project with good, bad and foreign logs and a test of its own."""
    here = project(tmp_path_factory.mktemp("mixed"), "reflexarc_logs = golden")
    (here / "elsewhere").mkdir()
    for name in ("golden/one.mcap", "golden/two.mcap", "elsewhere/three.mcap"):
        shutil.copy(log_path, here / name)
    rewrite(log_path, here / "golden/changed.mcap", edit_decisions(sideways))
    (here / "golden/empty.mcap").write_bytes(b"")
    (here / "test_it.py").write_text(
        "def test_it(replay):\n"
        f"    report = replay({str(log_path)!r}, level='node')\n"
        "    assert report.levels[0].compared == 61\n"
    )
    result = run_pytest(here)
    assert result.returncode == 1
    return result.stdout


def sideways(decision: Decision) -> None:
    decision.command.lateral_mps += 1


def test_each_log_under_the_named_directories_is_a_test_that_replays_it(outcome):
    assert "golden/one.mcap::replay PASSED" in outcome
    assert "golden/two.mcap::replay PASSED" in outcome
    assert "three" not in outcome


def test_a_log_that_replays_differently_fails_with_the_report(outcome):
    assert "golden/changed.mcap::replay FAILED" in outcome
    assert "changed.mcap: different" in outcome
    assert "first divergence: tick 0, command.lateral_mps" in outcome


def test_a_log_that_cannot_be_read_fails_with_one_line(outcome):
    assert "golden/empty.mcap::replay FAILED" in outcome
    assert "empty.mcap: expected a log, got an empty file" in outcome


def test_a_log_that_fails_shows_no_traceback(outcome):
    assert "Traceback" not in outcome
    assert "def runtest" not in outcome


def test_the_fixture_replays_any_log(outcome):
    assert "test_it.py::test_it PASSED" in outcome


def test_without_a_log_the_plugin_imports_nothing_but_pytest(tmp_path):
    here = project(tmp_path, "reflexarc_logs = golden")
    (here / "test_it.py").write_text(
        "import sys\n\n"
        "def test_it():\n"
        "    heavy = {'numpy', 'mcap', 'onnx', 'google.protobuf', 'reflexarc_runtime'}\n"
        "    assert not heavy & set(sys.modules)\n"
        "    ours = {n for n in sys.modules if n.startswith('reflexarc')}\n"
        "    assert ours == {'reflexarc_logs', 'reflexarc_logs.pytest_plugin'}\n"
    )
    result = run_pytest(here)
    assert result.returncode == 0, result.stdout


def test_without_the_option_no_log_is_collected(log_path, tmp_path):
    here = project(tmp_path, "")
    shutil.copy(log_path, here / "golden/log.mcap")
    assert run_pytest(here).returncode == pytest.ExitCode.NO_TESTS_COLLECTED
