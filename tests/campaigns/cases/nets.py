"""Test nets that catch nothing."""

import shutil
import sys
from pathlib import Path

from cases.case import Case, Outcome, Said, Stage


def _pytest(stage: Stage, name: str, *words: str) -> Said:
    """Run pytest in a copy of one of the folders, beside the store."""
    for folder in (name, "store"):
        shutil.copytree(stage.inputs / folder, stage.scratch / folder, symlinks=True)
    options = ("-q", "-p", "no:cacheprovider", "--rootdir", stage.scratch / name)
    where = ("-c", stage.scratch / name / "pyproject.toml", stage.scratch / name)
    return stage.command(sys.executable, "-m", "pytest", *options, *where, *words)


def _last(said: Said) -> str:
    lines = said.everything.strip().splitlines()
    return f"status {said.status}: {lines[-1][-120:] if lines else ''}"


def _typo(stage: Stage) -> Outcome:
    said = _pytest(stage, "typo")
    return Outcome(said.status != 0 and "tests/goldn" in said.everything, _last(said))


def _link(stage: Stage) -> Outcome:
    said = _pytest(stage, "symlink")
    return Outcome(said.status == 0 and "2 passed" in said.out, _last(said))


def _true_link(stage: Stage) -> Outcome:
    """The same where links are links: not every way in which the folder came keeps them."""
    shutil.copytree(stage.inputs, stage.scratch / "again", symlinks=True)
    log = stage.scratch / "again/symlink/tests/golden/drive.mcap"
    log.parent.chmod(0o755)
    log.unlink()
    log.symlink_to(Path("../../../store/drive.mcap"))
    said = _pytest(Stage(stage.scratch / "again", stage.scratch), "symlink")
    return Outcome(said.status == 0 and "2 passed" in said.out, _last(said))


def _lfs(stage: Stage) -> Outcome:
    said = _pytest(stage, "lfs")
    return Outcome(said.status == 1 and "git lfs pull" in said.out, _last(said))


CASES: tuple[Case, ...] = (
    Case("pytest-silent", "a named folder that is not there", "an error or a warning", _typo),
    Case("pytest-silent", "a log that is a link to a store outside", "2 passed", _link),
    Case("pytest-silent", "the same as a true link", "2 passed", _true_link),
    Case("pytest-silent", "a log that is a Git LFS pointer", "fails: `git lfs pull`", _lfs),
)
