"""What a node is given, in which order, and what becomes of what it says."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from reflexarc_logs.diffing.message_file import Stream
from reflexarc_logs.nodes import node_class
from reflexarc_logs.nodes.node_check import NodeCheck
from reflexarc_logs.nodes.node_class import NamedNode, NodeCrashError, NodeError
from reflexarc_logs.nodes.node_input import NodeInput
from reflexarc_logs.nodes.node_run import NodeRun
from support.foreign_logs import json_log

GOLDEN = Path(__file__).parents[2] / "golden"
JSON = Stream("/out", "", "json", "", b"")
Heard = list[tuple[str, Any, int]]


class Told:
    """A node that says what it is told to."""

    def __init__(self, answer: Callable[..., Any], topics: Any = None) -> None:
        self.heard: Heard = []
        self._answer = answer
        if topics is not None:
            self.topics = topics

    def on_message(self, topic: str, message: Any, time_ns: int) -> Any:
        self.heard.append((topic, message, time_ns))
        return self._answer(topic, message, time_ns)


class Named(NamedNode):
    """A node that is there already."""

    def make(self) -> node_class.AnyNode:
        return NODES[self.name]


NODES: dict[str, Any] = {}


def run(path: Path, node: Told, recorded: Stream | None = JSON) -> tuple[list[Any], Heard]:
    NODES["it"] = node
    found = NodeRun(Named("/out", "it", path.parent), NodeInput(path), recorded)
    return [json.loads(m.payload) for m in found.outputs], node.heard


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return json_log(
        tmp_path / "x.mcap",
        a=[(0, 10, 1), (1, 30, 3)],
        b=[(0, 20, {"x": 2})],
        out=[(0, 25, "recorded")],
    )


def test_it_hears_all_but_its_own_topic_on_the_log_s_clock(log: Path) -> None:
    _, heard = run(log, Told(lambda *_: None))
    assert heard == [("/a", 1, 17), ("/b", {"x": 2}, 27), ("/a", 3, 37)]


@pytest.mark.parametrize("topics", [("/b",), ["/b", "/none", "/out"], "/b"])
def test_it_hears_the_topics_that_it_names(log: Path, topics: Any) -> None:
    assert [topic for topic, *_ in run(log, Told(lambda *_: None, topics))[1]] == ["/b"]


def test_it_hears_none_of_the_topics_on_which_its_class_speaks(log: Path) -> None:
    NODES["it"] = node = Told(lambda *_: None)
    NodeRun(Named("/out", "it", log.parent, frozenset({"/out", "/a"})), NodeInput(log), JSON)
    assert [topic for topic, *_ in node.heard] == ["/b"]


def test_nothing_to_hear_is_an_error(log: Path) -> None:
    with pytest.raises(NodeError, match="nothing to feed it with; the log holds /a, /b, /out"):
        run(log, Told(lambda *_: None, ["/scan"]))


def test_messages_are_heard_by_log_time_also_where_the_file_has_another_order(
    tmp_path: Path,
) -> None:
    path = tmp_path / "x.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        first, second = (writer.register_channel("/a", "json", 0) for _ in range(2))
        for channel, at in ((first, 30), (second, 10), (first, 20), (second, 20)):
            writer.add_message(channel, at, f'"{channel} {at}"'.encode(), at)
        writer.finish()
    heard = run(path, Told(lambda *_: None))[1]
    assert heard == [("/a", "2 10", 10), ("/a", "1 20", 20), ("/a", "2 20", 20), ("/a", "1 30", 30)]


def one_after_the_other(topic: str, message: Any, time_ns: int) -> Any:
    yield 1
    yield "/out", 2
    yield "/else", 3


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (lambda *_: None, []),
        (lambda *_: {"x": 1}, [{"x": 1}]),
        (lambda *_: ("/out", {"x": 1}), [{"x": 1}]),
        (lambda *_: [{"x": 1}, ("/out", {"x": 2})], [{"x": 1}, {"x": 2}]),
        (lambda *_: ("/else", 5), []),
        (lambda *_: [], []),
        (one_after_the_other, [1, 2]),
    ],
)
def test_what_it_says_may_have_any_of_these_forms(
    log: Path, answer: Callable[..., Any], said: list[Any]
) -> None:
    assert run(log, Told(answer, "/b"))[0] == said


def test_its_error_names_the_message_at_which_it_was_raised(log: Path) -> None:
    node = Told(lambda topic, message, _: 1 / (message - 3) if topic == "/a" else None)
    with pytest.raises(NodeCrashError, match=r"/a, message 1, 0\.000 s into the log") as caught:
        run(log, node)
    assert isinstance(caught.value.__cause__, ZeroDivisionError)


def test_what_is_no_message_is_an_error(log: Path) -> None:
    with pytest.raises(NodeError, match=r"what it says of /a, message 0, .* is no json"):
        run(log, Told(lambda *_: {1j}))


class Commands:
    """Says again what each tick of our own logs commanded."""

    def __init__(self, change: Callable[[Any], Any] = lambda command: command) -> None:
        self._change = change

    def on_message(self, topic: str, message: Any, time_ns: int) -> Any:
        return self._change(message.decision.command) if topic == "/robot0/tick" else None


@pytest.mark.parametrize(
    "change", [lambda command: command, lambda command: as_dictionary(command)]
)
def test_protobuf_comes_and_goes_as_objects_or_dictionaries(change: Callable[[Any], Any]) -> None:
    NODES["it"] = Commands(change)
    check = NodeCheck(Named("/robot0/command", "it", GOLDEN))
    report = check.report(GOLDEN / "nominal.mcap")
    assert report.is_same, str(report)
    assert report.found is not None
    assert report.found.identical == 301


def as_dictionary(command: Any) -> dict[str, Any]:
    return {field.name: value for field, value in command.ListFields()}


def test_a_changed_field_is_found_with_its_margin() -> None:
    def slower(command: Any) -> Any:
        command.linear_mps *= 0.5
        return command

    NODES["it"] = Commands(slower)
    report = NodeCheck(Named("/robot0/command", "it", GOLDEN)).report(GOLDEN / "nominal.mcap")
    assert report.found is not None
    assert list(report.found.fields) == ["linear_mps"]
    assert "linear_mps: " in str(report)
    assert "allowed 0" in str(report)


def test_another_type_than_the_recorded_one_is_an_error() -> None:
    NODES["it"] = Told(lambda topic, message, _: message, ["/robot0/tick"])
    with pytest.raises(NodeError, match=r"expected reflexarc.Command, got reflexarc.Tick"):
        NodeCheck(Named("/robot0/command", "it", GOLDEN)).report(GOLDEN / "nominal.mcap")


def test_an_unknown_field_is_an_error() -> None:
    NODES["it"] = Told(lambda *_: {"speed": 1.0}, ["/robot0/tick"])
    with pytest.raises(NodeError, match="speed"):
        NodeCheck(Named("/robot0/command", "it", GOLDEN)).report(GOLDEN / "nominal.mcap")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("it", "expected my.module:Class"),
        ("json:Missing", "there is no class Missing in json"),
        ("no.such.module:Class", "ModuleNotFoundError"),
        ("broken.py:Class", "ZeroDivisionError"),
        ("none.py:Class", "FileNotFoundError"),
        ("node.py:Wants", "made without arguments"),
        ("node.py:Mute", "expected a method on_message"),
    ],
)
def test_a_class_that_cannot_be_a_node_says_why(name: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "broken.py").write_text("1 / 0\n")
    wants = "class Wants:\n    def __init__(self, it):\n        pass\n"
    (tmp_path / "node.py").write_text(f"{wants}class Mute:\n    pass\n")
    with pytest.raises(NodeError, match=words):
        NamedNode("/out", name, tmp_path).make()
