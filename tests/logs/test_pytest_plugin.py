import shutil
from pathlib import Path

import pytest

from reflexarc_logs.replaying.report import ReplayReport
from reflexarc_runtime.messages_pb2 import Decision
from support.plugin_runs import project, run_pytest
from support.policies import exported
from support.recordings import CONTRACT
from support.rewriting import edit_decisions, flip_bit, rewrite


@pytest.fixture(scope="module")
def outcome(log_path: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """What pytest says of a project with good, bad and foreign logs and a test of its own."""
    here = project(tmp_path_factory.mktemp("mixed"), "reflexarc_logs = golden")
    (here / "elsewhere").mkdir()
    for name in ("golden/one.mcap", "golden/two.mcap", "elsewhere/three.mcap"):
        shutil.copy(log_path, here / name)
    rewrite(log_path, here / "golden/changed.mcap", edit_decisions(sideways))
    (here / "golden/empty.mcap").write_bytes(b"")
    middle = flip_bit(log_path.read_bytes(), log_path.stat().st_size // 2)
    (here / "golden/fell over.mcap").write_bytes(middle)
    (here / "golden/cut off.mcap").write_bytes(log_path.read_bytes()[:-9000])
    other = {"policy.onnx": exported(CONTRACT, 8)}
    rewrite(log_path, here / "golden/swapped one.mcap", attachments=other)
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


@pytest.mark.parametrize(
    ("what", "command"),
    [
        ("fell over.mcap: damaged: the CRC", "recover 'golden/fell over.mcap' -o FIXED.mcap"),
        ("cut off.mcap: expected a finished", "recover 'golden/cut off.mcap' -o FIXED.mcap"),
        (
            "swapped one.mcap: the attached policy is not the one that the log names",
            "replay 'golden/swapped one.mcap' --policy POLICY.onnx",
        ),
    ],
)
def test_what_is_broken_comes_with_the_command_that_helps_as_it_is_typed(outcome, what, command):
    line = next(line for line in outcome.splitlines() if line.startswith(f"golden/{what}"))
    assert f"`reflexarc {command}`" in line


def test_a_log_that_fails_shows_no_traceback(outcome):
    assert "Traceback" not in outcome
    assert "def runtest" not in outcome


def test_the_fixture_replays_any_log(outcome):
    assert "test_it.py::test_it PASSED" in outcome


def test_without_a_log_the_plugin_imports_nothing_but_pytest(tmp_path):
    here = project(tmp_path, "reflexarc_logs = golden")
    (here / "golden/never-opened.mcap").write_bytes(b"")
    (here / "test_it.py").write_text(
        "import sys\n\n"
        "def test_it():\n"
        "    heavy = {'numpy', 'mcap', 'onnx', 'google.protobuf', 'reflexarc_runtime'}\n"
        "    assert not heavy & set(sys.modules)\n"
        "    ours = {n for n in sys.modules if n.startswith('reflexarc')}\n"
        "    mine = {'', '.named_logs', '.pytest_options', '.pytest_plugin'}\n"
        "    assert ours == {f'reflexarc_logs{name}' for name in mine}\n"
    )
    result = run_pytest(here, "test_it.py")
    assert result.returncode == 0, result.stdout


def test_without_the_option_no_log_is_collected(log_path, tmp_path):
    here = project(tmp_path, "")
    shutil.copy(log_path, here / "golden/log.mcap")
    assert run_pytest(here).returncode == pytest.ExitCode.NO_TESTS_COLLECTED


def passing(here: Path) -> Path:
    (here / "test_it.py").write_text("def test_it():\n    pass\n")
    return here


@pytest.mark.parametrize("place", ["goldn", "golden", "golden/log.mcap", "gold*/x"])
def test_a_place_without_a_log_is_an_error_whatever_runs(place, tmp_path):
    here = passing(project(tmp_path, f"reflexarc_logs = {place}"))
    for arguments in ((), ("test_it.py",)):
        result = run_pytest(here, *arguments)
        assert result.returncode == pytest.ExitCode.USAGE_ERROR
        assert f"ERROR: reflexarc_logs: {place}: " in result.stderr


def test_a_link_to_a_store_outside_is_a_test_in_any_form(log_path, tmp_path):
    (tmp_path / "store").mkdir()
    shutil.copy(log_path, tmp_path / "store/log.mcap")
    (tmp_path / "here").mkdir()
    here = project(tmp_path / "here", "reflexarc_logs = golden linked")
    (here / "golden/link.mcap").symlink_to("../../store/log.mcap")
    (here / "golden/as-text.mcap").write_text("../../store/log.mcap")  # git, where none are made
    (here / "golden/LOUD.MCAP").symlink_to("../../store/log.mcap")
    (here / "linked").symlink_to("../store")
    outcome = run_pytest(here)
    assert outcome.returncode == 0, outcome.stdout
    assert "4 passed" in outcome.stdout


def test_what_stands_for_a_log_that_was_not_fetched_fails_and_says_how_to_fetch_it(tmp_path):
    here = project(tmp_path, "reflexarc_logs = golden")
    pointer = "version https://git-lfs.github.com/spec/v1\noid sha256:1234\nsize 58347\n"
    (here / "golden/lfs.mcap").write_text(pointer)
    (here / "golden/annex.mcap").symlink_to("../.git/annex/objects/1234")
    outcome = run_pytest(here)
    assert "lfs.mcap: is a Git LFS pointer, not the log itself: `git lfs pull`" in outcome.stdout
    assert "annex.mcap: a link to ../.git/annex/objects/1234, which is not there" in outcome.stdout
    assert "2 failed" in outcome.stdout


UNREACHED = {
    "testpaths = unit": "it is not where pytest collects: add its folder to testpaths",
    "norecursedirs = gold*": "pytest leaves it out: norecursedirs",
}


@pytest.mark.parametrize("workers", [(), ("-p", "xdist", "-n", "2")], ids=["alone", "xdist"])
@pytest.mark.parametrize("option", UNREACHED)
def test_a_log_that_a_whole_run_does_not_reach_fails(option, workers, log_path, tmp_path):
    here = project(tmp_path, f"reflexarc_logs = golden\n{option}")
    shutil.copy(log_path, here / "golden/log.mcap")
    (here / "unit").mkdir()
    passing(here / "unit")
    outcome = run_pytest(here, *workers)
    assert outcome.returncode == 1
    assert f"golden/log.mcap: {UNREACHED[option]}" in outcome.stdout
    assert "1 failed, 1 passed" in outcome.stdout


@pytest.mark.parametrize("arguments", [("unit",), ("--ignore=golden",), ("--ignore-glob=*gold*",)])
def test_a_log_that_somebody_left_out_is_counted(arguments, log_path, tmp_path):
    here = project(tmp_path, "reflexarc_logs = golden/")
    shutil.copy(log_path, here / "golden/log.mcap")
    (here / "unit").mkdir()
    passing(here / "unit")
    outcome = run_pytest(here, *arguments)
    assert outcome.returncode == 0
    assert "reflexarc_logs: 1 of 1 logs were not among the tests of this run" in outcome.stdout


def test_a_report_prints_its_lines_and_its_verdict_stands_in_a_failed_assertion():
    report = ReplayReport("a.mcap", "ab" * 32, True, "numpy", "numpy", (), ())
    assert str(report) == "\n".join(report.lines())
    assert repr(report) == "<ReplayReport a.mcap: nothing was compared>"
