"""A log is a test: pytest collects the logs under the places that the project names.

    [tool.pytest.ini_options]
    reflexarc_logs = ["tests/golden"]

One test a log; it fails with the report of its replay. With `reflexarc_policy` it judges that
policy on the log instead: see `pytest_options`. A place that is missing or holds no log is an
error, and so is a log that a whole run of the tests does not reach: see `named_logs`. The fixture
`replay` serves tests that want more. Until it meets a log, the plugin imports nothing but pytest.
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
from reflexarc_logs.pytest_options import LogOptions, OptionError, add_options, log_options

if TYPE_CHECKING:
    from reflexarc_logs.replaying.report import ReplayReport
    from reflexarc_logs.testing.log_trial import LogTrial

INI = "reflexarc_logs"
NODES = "reflexarc_nodes"
NODE_RULES = "reflexarc_node_rules"
_NET = pytest.StashKey[LogNet]()
_OPTIONS = pytest.StashKey[LogOptions]()
_TRIAL = pytest.StashKey["LogTrial"]()
_ACCEPTED = "reflexarc_accepted"
"""Property of a test that accepted a new baseline: what is said of it."""
_HEARD = pytest.StashKey[int]()
"""How many logs the workers of pytest-xdist did not reach: they collect, not their controller."""
_UNREACHED = "reflexarc_logs_unreached"
_WHOLE = "reflexarc_logs_whole"


class LogTestError(Exception):
    """A log does not replay as it was recorded, or a candidate is beyond its limits."""


class LogFile(pytest.File):
    """A log under one of the named places."""

    def collect(self) -> Iterator[pytest.Item]:
        """The replay of this log, if it is ours, or the judgement of the candidate on it; and each
        of the project's nodes that it feeds.
        """
        if self.config.getini(NODES):
            from reflexarc_logs.nodes.node_tests import may_be_replayed, node_items

            yield from node_items(self)
            if not may_be_replayed(self.path):
                return
        is_judged = self.config.stash[_OPTIONS].policy is not None
        yield LogItem.from_parent(self, name="candidate" if is_judged else "replay")


class LogItem(pytest.Item):
    """Replays a log at every level that it supports, or judges a candidate on it."""

    def runtest(self) -> None:
        """Do so; where that is asked for, accept what differs as the new baseline.

        Raises:
            LogTestError: something was different, or nothing could be compared.
            ReflexarcError: the log cannot be read.
            OSError: not even its first bytes.
        """
        path = followed(self.path)
        if self.config.stash[_OPTIONS].update:
            self._accept(path)
        elif failure := _trial(self.config).failure(path):
            raise LogTestError(failure)

    def _accept(self, path: Path) -> None:
        from reflexarc_logs.testing.baseline import accept

        accepted = accept(path, self.config.stash[_OPTIONS].policy)
        if accepted is not None:
            typed = _trial(self.config).typed(self.path)
            self.user_properties.append((_ACCEPTED, "\n".join(accepted.lines(typed))))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The report or the error's one line, without a traceback; of a bug, all of it."""
        from reflexarc_runtime.errors import ReflexarcError

        if isinstance(excinfo.value, LogTestError | ReflexarcError | OSError):
            near = str(_trial(self.config).typed(self.path))
            return str(excinfo.value).replace(str(self.path), near)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the test is, and what it is called."""
        return self.path, None, f"{self.name} of {self.path.name}"


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
    """Declare the options."""
    help_text = "folders, logs, or patterns of them, relative to the root, whose logs are tests"
    parser.addini(INI, help_text, "args", [])
    parser.addini(
        NODES, "topics, and the classes that speak on them: see anyones-node.md", "linelist", []
    )
    parser.addini(NODE_RULES, "what may differ in what they say: a file as of `diff`", "string", "")
    add_options(parser)


def pytest_sessionstart(session: pytest.Session) -> None:
    """Look whether every named place holds a log, and whether the options can be meant.

    Raises:
        UsageError: one does not, or cannot.
    """
    config = session.config
    try:
        logs = named_logs(config.rootpath, config.getini(INI))
    except NetError as error:
        raise pytest.UsageError(f"{INI}: {error}") from None
    try:
        config.stash[_OPTIONS] = options = log_options(config)
    except OptionError as error:
        raise pytest.UsageError(str(error)) from None
    if options.policy is not None:
        _trial(config)
    config.stash[_NET] = LogNet(logs)
    if nodes := config.getini(NODES):
        from reflexarc_logs.nodes.node_tests import prepare

        prepare(config, nodes, config.getini(NODE_RULES), has_logs=bool(logs))


def _trial(config: pytest.Config) -> "LogTrial":
    """How logs are tested in this run.

    Raises:
        UsageError: limits that are none.
    """
    from reflexarc_logs.testing.log_trial import LogTrial, limits_of
    from reflexarc_runtime.errors import UsageError

    if _TRIAL not in config.stash:
        options = config.stash[_OPTIONS]
        try:
            limits = limits_of(options.limits)
        except UsageError as error:
            raise pytest.UsageError(f"reflexarc: {error}") from None
        config.stash[_TRIAL] = LogTrial(options.policy, limits, config.invocation_params.dir)
    return config.stash[_TRIAL]


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
