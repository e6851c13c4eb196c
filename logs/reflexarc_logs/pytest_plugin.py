"""A log is a test: pytest collects `*.mcap` under the directories that the project names.

    [tool.pytest.ini_options]
    reflexarc_logs = ["tests/golden"]

One test a log; it fails with the report of its replay. The fixture `replay` serves tests that
want more. Until it meets a log, the plugin imports nothing but pytest.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from reflexarc_logs.replaying.report import ReplayReport

SUFFIX = ".mcap"
INI = "reflexarc_logs"


class ReplayFailedError(Exception):
    """A log does not replay as it was recorded."""

    def __init__(self, report: "ReplayReport") -> None:
        super().__init__("\n".join(report.lines()))


class LogFile(pytest.File):
    """A log under one of the named directories."""

    def collect(self) -> Iterator["LogItem"]:
        """One test: the replay of this log."""
        yield LogItem.from_parent(self, name="replay")


class LogItem(pytest.Item):
    """Replays a log at every level that it supports."""

    def runtest(self) -> None:
        """Replay.

        Raises:
            ReplayFailedError: something was different, or nothing could be compared.
            ReflexarcError: the log cannot be read.
        """
        from reflexarc_logs.replaying.replay import replay

        report = replay(self.path)
        if report.exit_status:
            raise ReplayFailedError(report)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The report or the error's one line, without a traceback; of a bug, all of it."""
        from reflexarc_runtime.errors import ReflexarcError

        if isinstance(excinfo.value, ReplayFailedError | ReflexarcError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the test is, and what it is called."""
        return self.path, None, f"replay of {self.path.name}"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the ini option."""
    parser.addini(INI, "directories, relative to the root, whose *.mcap are tests", "args", [])


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> LogFile | None:
    """Take the logs that lie under one of the named directories."""
    if file_path.suffix != SUFFIX:
        return None
    root = parent.config.rootpath
    named = [(root / directory).resolve() for directory in parent.config.getini(INI)]
    if not any(file_path.resolve().is_relative_to(directory) for directory in named):
        return None
    return LogFile.from_parent(parent, path=file_path)


@pytest.fixture
def replay() -> "Callable[..., ReplayReport]":
    """A callable: path of a log (and what `replaying.replay.replay` takes) → `ReplayReport`."""
    from reflexarc_logs.replaying.replay import replay as replay_log

    return replay_log
