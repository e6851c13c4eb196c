"""A log is a test: pytest collects the logs under the places that the project names.

    [tool.pytest.ini_options]
    reflexarc_logs = ["tests/golden"]

One test a log; it fails with the report of its replay. A place that is missing or holds no log is
an error, and so is a log that a whole run of the tests does not reach: see `named_logs`. The
fixture `replay` serves tests that want more. Until it meets a log, the plugin imports nothing but
pytest.
"""

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from reflexarc_logs.named_logs import (
    LOG_SUFFIX,
    LogNet,
    NetError,
    WhatRuns,
    followed,
    named_logs,
)

if TYPE_CHECKING:
    from reflexarc_logs.replaying.report import ReplayReport

INI = "reflexarc_logs"
NODES = "reflexarc_nodes"
NODE_RULES = "reflexarc_node_rules"
_NET = pytest.StashKey[LogNet]()
_HEARD = pytest.StashKey[int]()
"""How many logs the workers of pytest-xdist did not reach: they collect, not their controller."""
_ACCEPTED = "reflexarc_accepted"
"""Property of a test that accepted a new baseline: what is said of it."""
_UNREACHED = "reflexarc_logs_unreached"
_WHOLE = "reflexarc_logs_whole"


class ReplayFailedError(Exception):
    """A log does not replay as it was recorded."""

    def __init__(self, report: "ReplayReport") -> None:
        super().__init__(str(report))


class LogFile(pytest.File):
    """A log under one of the named places."""

    def collect(self) -> Iterator[pytest.Item]:
        """The replay of this log, if it is ours; and each of the project's nodes that it feeds."""
        if self.config.getini(NODES):
            from reflexarc_logs.nodes.node_tests import may_be_replayed, node_items

            yield from node_items(self)
            if not may_be_replayed(self.path):
                return
        yield LogItem.from_parent(self, name="replay")


class LogItem(pytest.Item):
    """Replays a log at every level that it supports."""

    def runtest(self) -> None:
        """Replay.

        Raises:
            ReplayFailedError: something was different, or nothing could be compared.
            ReflexarcError: the log cannot be read.
            OSError: not even its first bytes.
        """
        from reflexarc_logs.replaying.replay import replay

        report = replay(followed(self.path))
        if report.exit_status:
            raise ReplayFailedError(report)

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The report or the error's one line, without a traceback; of a bug, all of it."""
        from reflexarc_runtime.errors import ReflexarcError

        if isinstance(excinfo.value, ReplayFailedError | ReflexarcError | OSError):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the test is, and what it is called."""
        return self.path, None, f"replay of {self.path.name}"


class UnreachedLog(pytest.Item):
    """Fails in the place of a log that no test replays, though the run should have reached it."""

    def __init__(self, *, log: Path, reason: str, **others: Any) -> None:
        super().__init__(**others)
        self._log, self._reason = log, reason

    def runtest(self) -> None:
        """Say so.

        Raises:
            NetError: always.
        """
        raise NetError(f"{self._log}: {self._reason}")

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """One line."""
        return str(excinfo.value)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the log is."""
        return self._log, None, f"replay of {self._log.name}"


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the ini option."""
    help_text = "folders, logs, or patterns of them, relative to the root, whose logs are tests"
    parser.addini(INI, help_text, "args", [])
    parser.addini(
        NODES, "topics, and the classes that speak on them: see anyones-node.md", "linelist", []
    )
    parser.addini(NODE_RULES, "what may differ in what they say: a file as of `diff`", "string", "")
    update_help = "record anew what differs, by hand: old and new are shown"
    parser.getgroup("reflexarc").addoption(
        "--reflexarc-update", action="store_true", help=update_help
    )


def pytest_sessionstart(session: pytest.Session) -> None:
    """Look whether every named place holds a log.

    Raises:
        UsageError: one does not.
    """
    config = session.config
    try:
        logs = named_logs(config.rootpath, config.getini(INI))
    except NetError as error:
        raise pytest.UsageError(f"{INI}: {error}") from None
    config.stash[_NET] = LogNet(logs)
    if nodes := config.getini(NODES):
        from reflexarc_logs.nodes.node_tests import prepare

        prepare(config, nodes, config.getini(NODE_RULES), has_logs=bool(logs))


def pytest_collect_file(file_path: Path, parent: pytest.Collector) -> LogFile | None:
    """Take the logs that lie at one of the named places."""
    if file_path.suffix.lower() != LOG_SUFFIX or not parent.config.stash[_NET].take(file_path):
        return None
    return LogFile.from_parent(parent, path=file_path)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(
    session: pytest.Session, config: pytest.Config, items: list[pytest.Item]
) -> None:
    """Put a test that fails in the place of each log that this run should have reached."""
    net = config.stash[_NET]
    for log, reason in net.unreached(_what_runs(config)):
        name = f"replay of {log.name}"
        items.append(UnreachedLog.from_parent(session, name=name, log=log, reason=reason))
    if hasattr(config, "workeroutput"):
        config.workeroutput[_UNREACHED] = len(net.left)


def _what_runs(config: pytest.Config) -> WhatRuns:
    here = config.invocation_params.dir
    return WhatRuns(
        places=[_absolute(here, word.split("::")[0]) for word in config.args],
        is_whole=_is_whole(config),
        ignored=[_absolute(here, path) for path in config.getoption("ignore") or ()],
        ignored_patterns=[str(here / glob) for glob in config.getoption("ignore_glob") or ()],
    )


def _absolute(here: Path, path: str) -> Path:
    return Path(os.path.abspath(here / path))


def _is_whole(config: pytest.Config) -> bool:
    """Whether the whole project's tests run: nobody named any."""
    if hasattr(config, "workerinput"):
        return bool(config.workerinput[_WHOLE])
    if config.args_source == pytest.Config.ArgsSource.TESTPATHS:
        return True
    here = config.invocation_params.dir == config.rootpath
    return here and config.args_source == pytest.Config.ArgsSource.INVOCATION_DIR


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """Tell a worker of pytest-xdist what only its controller knows."""
    node.workerinput[_WHOLE] = _is_whole(node.config)


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    """Hear from a worker of pytest-xdist how many logs it did not reach."""
    heard = getattr(node, "workeroutput", {}).get(_UNREACHED)
    if heard is not None:
        node.config.stash[_HEARD] = heard


def pytest_terminal_summary(terminalreporter: Any, config: pytest.Config) -> None:
    """Say what was recorded anew, and how many logs were not among the tests of this run."""
    _tell_accepted(terminalreporter)
    net = config.stash.get(_NET, None)
    if net is None:
        return  # the session did not begin
    left = config.stash.get(_HEARD, len(net.left))
    if left:
        count = f"{left} of {len(net.logs)} logs"
        terminalreporter.write_line(f"{INI}: {count} were not among the tests of this run")


def _tell_accepted(terminalreporter: Any) -> None:
    told = [
        text
        for report in terminalreporter.stats.get("passed", ())
        for name, text in report.user_properties
        if name == _ACCEPTED
    ]
    if told:
        terminalreporter.section("reflexarc: new baselines")
    for text in sorted(told):
        terminalreporter.write_line(text)


@pytest.fixture
def replay() -> "Callable[..., ReplayReport]":
    """A callable: path of a log (and what `replaying.replay.replay` takes) → `ReplayReport`."""
    from reflexarc_logs.replaying.replay import replay as replay_log

    return replay_log
