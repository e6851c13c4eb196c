"""The tests of pytest's plugin that feed nodes: one for each log and node.

    [tool.pytest.ini_options]
    reflexarc_logs = ["bags"]
    reflexarc_nodes = {"/cmd_vel" = "my.module:Controller"}
    reflexarc_node_rules = "tolerances.toml"

A node is tested on a log that holds its topic; and on one of another system that holds no node's
topic, where its test fails until somebody records what it says: a log that no test looks at would
be one that nobody misses.
"""

import ast
import os
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from reflexarc_logs.diffing.diff_rules import DiffRules, read_rules
from reflexarc_logs.named_logs import followed
from reflexarc_logs.nodes.node_check import NodeCheck
from reflexarc_logs.nodes.node_class import NamedNode, NodeCrashError
from reflexarc_logs.nodes.node_input import is_of_another_system, topics_in
from reflexarc_logs.nodes.node_report import UPDATE, NodeReport
from reflexarc_runtime.errors import LogError, ReflexarcError, UsageError
from reflexarc_runtime.words.shown import plain

NODES = "reflexarc_nodes"
RULES = "reflexarc_node_rules"


ACCEPTED = "reflexarc_accepted"
"""Property of a test that recorded anew: old beside new."""
_CHECKS = pytest.StashKey[Sequence[NodeCheck]]()


class NodeFailedError(Exception):
    """A node does not say what was recorded."""

    def __init__(self, report: NodeReport) -> None:
        super().__init__(str(report))


class NodeItem(pytest.Item):
    """Feeds a node from a log, and compares what it says with what was recorded."""

    def __init__(self, *, check: NodeCheck, **others: Any) -> None:
        super().__init__(**others)
        self._check = check

    def runtest(self) -> None:
        """Compare; with `--reflexarc-update`, record anew what differs.

        Raises:
            NodeFailedError: something differs, or nothing could be compared.
            NodeCrashError: the node raised an error.
            ReflexarcError: the node cannot be made, or the log not be read.
            OSError: the log cannot be read, or not be written.
        """
        path = _shown(followed(self.path))
        if not self.config.getoption(UPDATE):
            report = self._check.report(path)
            if not report.is_same:
                raise NodeFailedError(report)
            return
        report = self._check.record_anew(path)
        if report.found is None:
            raise NodeFailedError(report)
        if not report.is_same:
            self.user_properties.append((ACCEPTED, "\n".join(_accepted(report, path))))

    def repr_failure(self, excinfo: pytest.ExceptionInfo[BaseException], style: Any = None) -> Any:
        """The report or the error's one line; of a node's own error, where in it."""
        error = excinfo.value
        if isinstance(error, NodeFailedError | ReflexarcError | OSError):
            return str(error)
        if isinstance(error, NodeCrashError) and error.__cause__ is not None:
            return "\n".join([f"{error}:", *_inside(error.__cause__)])
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, None, str]:
        """Where the test is, and what it is called."""
        return self.path, None, f"{self.name} on {self.path.name}"


def prepare(config: pytest.Config, named: Sequence[str], rules: str, *, has_logs: bool) -> None:
    """Take what the project says of its nodes.

    Args:
        config: of this run.
        named: the lines of `reflexarc_nodes`.
        rules: path of the rules' file, relative to the root; empty: there is none.
        has_logs: whether the project names any logs.

    Raises:
        UsageError: it is malformed; or there is no log to feed a node from; or logs shall be
            recorded anew by something else than a hand.
    """
    try:
        nodes = named_nodes(config.rootpath, named)
        read = read_rules(config.rootpath / rules) if rules else DiffRules()
    except ReflexarcError as error:
        raise pytest.UsageError(str(error)) from None
    if not has_logs:
        raise pytest.UsageError(f"{NODES}: there is nothing to feed them from: set reflexarc_logs")
    many = hasattr(config, "workerinput") or config.getoption("numprocesses", None)
    if config.getoption(UPDATE) and (many or UPDATE not in config.invocation_params.args):
        raise pytest.UsageError(f"{UPDATE}: only by hand: on pytest's own line, and without -n")
    config.stash[_CHECKS] = tuple(NodeCheck(node, read, rules) for node in nodes)


def node_items(file: pytest.File) -> Iterator[NodeItem]:
    """The tests of a log: one for each node whose topic it holds."""
    for check in _on(followed(file.path), file.config.stash[_CHECKS]):
        name = f"{check.named.topic} of {check.named.name}"
        yield NodeItem.from_parent(file, name=name, check=check)


def may_be_replayed(path: Path) -> bool:
    """Whether a log is for `replay` to judge: ours, or nothing that can be read."""
    try:
        return not is_of_another_system(followed(path))
    except (LogError, OSError):
        return True


def named_nodes(root: Path, said: Sequence[str]) -> tuple[NamedNode, ...]:
    """The nodes that a project names: a table of TOML, or lines `TOPIC = module:Class`.

    Raises:
        UsageError: it is neither.
    """
    is_table = bool(said) and said[0].startswith("{")
    pairs = _table(said[0]) if is_table else [_line(line) for line in said]
    nodes = tuple(
        NamedNode(topic, name, root, frozenset(other for other, same in pairs if same == name))
        for topic, name in pairs
    )
    for node in nodes:
        if not (node.topic.startswith("/") and ":" in node.name):
            raise UsageError(
                f'{NODES}: expected "/topic" = "my.module:Class", got {node.topic!r} = '
                f"{node.name!r}"
            )
    if len({node.topic for node in nodes}) < len(nodes):
        raise UsageError(f"{NODES}: a topic is named twice")
    return nodes


def _table(text: str) -> list[tuple[str, str]]:
    """What pytest makes of a table in `ini_options`: the text of a dictionary."""
    try:
        table = ast.literal_eval(text)
        return [(str(topic), str(name)) for topic, name in table.items()]
    except (ValueError, SyntaxError, AttributeError):
        raise UsageError(f"{NODES}: expected a table of topics, got {text[:60]}") from None


def _line(text: str) -> tuple[str, str]:
    topic, _, name = text.partition("=")
    return topic.strip().strip("\"'"), name.strip().strip("\"'")


def _on(path: Path, checks: Sequence[NodeCheck]) -> Sequence[NodeCheck]:
    try:
        topics = topics_in(path)
        holding = [check for check in checks if check.named.topic in topics]
        return holding or (checks if is_of_another_system(path) else ())
    except (LogError, OSError):
        return ()  # the replay of this log says what is wrong with it


def _shown(path: Path) -> Path:
    """As it is typed from here, if it lies below."""
    here = Path.cwd()
    return path.relative_to(here) if path.is_relative_to(here) else path


def _accepted(report: NodeReport, path: Path) -> Iterator[str]:
    yield f"recorded anew: {report.summary()}"
    lines = list(report.lines())[1:]
    yield from lines[: lines.index("  next:")] if "  next:" in lines else lines
    found = report.found
    is_other = found is not None and found.messages_a != found.messages_b
    if is_other and os.path.exists(path.parent / "metadata.yaml"):
        yield "  metadata.yaml beside it counts what was there before: `ros2 bag reindex`"


def _inside(error: BaseException) -> Iterator[str]:
    """Where in the node's own code an error was raised, the last lines of the way there."""
    ours = os.path.dirname(__file__)
    frames = [
        f for f in traceback.extract_tb(error.__traceback__) if not f.filename.startswith(ours)
    ]
    for frame in frames[-6:]:
        yield f"  {plain(frame.filename)}:{frame.lineno}: {frame.line}"
    yield f"  {type(error).__name__}: {error}"
