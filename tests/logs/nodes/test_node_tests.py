"""Nodes as tests of a project: how they are named, on which logs they are, what a hand may do."""

import random
import shutil
from pathlib import Path

import pytest

from reflexarc_logs.diffing.message_file import MessageFile
from reflexarc_logs.nodes.node_check import NodeCheck
from reflexarc_logs.nodes.node_class import NamedNode, NodeError
from reflexarc_logs.nodes.node_tests import named_nodes
from reflexarc_runtime.errors import UsageError
from support.foreign_logs import json_log
from support.node_projects import run_pytest, write_project
from support.ros2 import Twist
from support.scan_bags import scans, write_bag

GOLDEN = Path(__file__).parents[2] / "golden" / "nominal.mcap"
DOUBLE = """class Double:
    factor = 2

    def on_message(self, topic, message, time_ns):
        return message * self.factor if topic == "/in" else None


class Again:
    topics = ("/robot0/tick",)

    def on_message(self, topic, message, time_ns):
        return message.decision.command
"""
PROJECT = """[tool.pytest.ini_options]
reflexarc_logs = ["logs"]
reflexarc_nodes = {"/out" = "double:Double", "/robot0/command" = "double:Again"}
"""


def doubled(path: Path, count: int = 20) -> Path:
    path.parent.mkdir(exist_ok=True)
    ins = [(k, 100 * k, k) for k in range(count)]
    outs = [(k, 100 * k + 50, 2 * k) for k in range(count)]
    return json_log(path, **{"in": ins, "out": outs})


@pytest.mark.parametrize(
    "said",
    [
        ["{'/a': 'm:C', '/b': 'n.m:D'}"],
        ["/a = m:C", "/b=n.m:D"],
        ["\"/a\" = \"m:C\"", "'/b' = 'n.m:D'"],
    ],
)  # fmt: skip
def test_nodes_are_a_table_or_lines(said: list[str]) -> None:
    assert named_nodes(Path("/x"), said) == (
        NamedNode("/a", "m:C", Path("/x"), frozenset({"/a"})),
        NamedNode("/b", "n.m:D", Path("/x"), frozenset({"/b"})),
    )


@pytest.mark.parametrize("said", ["{'/a': 'm'}", "{oops", "a = m:C", "/a", "{'/a'}"])
def test_anything_else_is_refused(said: str) -> None:
    with pytest.raises(UsageError, match="reflexarc_nodes: expected"):
        named_nodes(Path("/x"), [said])
    with pytest.raises(UsageError, match="named twice"):
        named_nodes(Path("/x"), ["/a = m:C", "/a = m:D"])


def test_each_log_has_the_nodes_whose_topics_it_holds(tmp_path: Path) -> None:
    here = write_project(tmp_path, PROJECT, double=DOUBLE)
    doubled(here / "logs/json.mcap")
    shutil.copy(GOLDEN, here / "logs/ours.mcap")
    (here / "logs/broken.mcap").write_bytes(GOLDEN.read_bytes()[:5000])
    said = run_pytest(here, "logs").stdout
    assert "json.mcap::/out of double:Double PASSED" in said
    assert "ours.mcap::/robot0/command of double:Again PASSED" in said
    assert "ours.mcap::replay PASSED" in said
    assert "broken.mcap::replay FAILED" in said
    assert "1 failed, 3 passed" in said


def test_a_table_of_pytest_9_has_lines(tmp_path: Path) -> None:
    if int(pytest.__version__.partition(".")[0]) < 9:
        pytest.skip("[tool.pytest] came with pytest 9")
    settings = PROJECT.replace(".ini_options", "").replace(
        '{"/out" = "double:Double", "/robot0/command" = "double:Again"}', '["/out = double:Double"]'
    )
    here = write_project(tmp_path, settings, double=DOUBLE)
    doubled(here / "logs/json.mcap")
    assert "1 passed" in run_pytest(here, "logs").stdout


def test_recording_anew_is_for_hands(tmp_path: Path) -> None:
    here = write_project(tmp_path, PROJECT, double=DOUBLE.replace("= 2", "= 3"))
    log = doubled(here / "logs/json.mcap")
    before = log.read_bytes()
    refused = run_pytest(here, "logs", "-o", "addopts=--reflexarc-update")
    assert refused.returncode == pytest.ExitCode.USAGE_ERROR
    assert "--reflexarc-update: by hand only" in refused.stderr
    many = run_pytest(here, "logs", "-n", "1", "--reflexarc-update")
    assert "--reflexarc-update: only by hand" in many.stderr
    assert log.read_bytes() == before
    accepted = run_pytest(here, "logs", "--reflexarc-update")
    assert accepted.returncode == 0, accepted.stdout
    assert "recorded anew: logs/json.mcap: double:Double on /out: 1 of 20 messages" in (
        accepted.stdout
    )
    assert "message 1, 0.000 s into the log: the value: recorded 2, said 3" in accepted.stdout
    after = log.read_bytes()
    again = run_pytest(here, "logs", "--reflexarc-update")
    assert "recorded anew" not in again.stdout
    assert log.read_bytes() == after


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (PROJECT.replace('["logs"]', "[]"), "set reflexarc_logs"),
        (PROJECT + 'reflexarc_node_rules = "none.toml"\n', "none.toml"),
        (PROJECT.replace("double:Double", "Double"), "expected"),
    ],
)
def test_settings_that_cannot_work_end_at_once(settings: str, words: str, tmp_path: Path) -> None:
    doubled(write_project(tmp_path, settings, double=DOUBLE) / "logs/json.mcap")
    result = run_pytest(tmp_path)
    assert result.returncode == pytest.ExitCode.USAGE_ERROR
    assert words in result.stderr


def test_a_run_of_ours_is_never_recorded_anew(tmp_path: Path) -> None:
    write_project(tmp_path, "", double=DOUBLE.replace("decision.command", "decision"))
    log = shutil.copy(GOLDEN, tmp_path / "x.mcap")
    (tmp_path / "slower.py").write_text(
        "class Slower:\n"
        "    topics = '/robot0/tick'\n"
        "    def on_message(self, topic, message, time_ns):\n"
        "        return {'linear_mps': 0.125}\n"
    )
    check = NodeCheck(NamedNode("/robot0/command", "slower.py:Slower", tmp_path))
    with pytest.raises(NodeError, match="only a whole log of another system is recorded anew"):
        check.record_anew(Path(log))
    assert Path(log).read_bytes() == GOLDEN.read_bytes()


def test_who_does_not_say_the_same_twice_is_not_recorded(tmp_path: Path) -> None:
    (tmp_path / "dice.py").write_text(
        "import random\n"
        "class Dice:\n"
        "    def on_message(self, topic, message, time_ns):\n"
        "        return random.random()\n"
    )
    log = doubled(tmp_path / "logs/json.mcap")
    before = log.read_bytes()
    random.seed(0)
    with pytest.raises(NodeError, match="does not say the same twice"):
        NodeCheck(NamedNode("/out", "dice.py:Dice", tmp_path)).record_anew(log)
    assert log.read_bytes() == before


SAYS = """class Standing:
    says = {"/cmd_vel": "geometry_msgs/msg/Twist"}

    def on_message(self, topic, message, time_ns):
        return {"linear": {"x": 0.25}}


class Untyped(Standing):
    says = ""
"""


def test_a_topic_of_ros_2_that_was_not_recorded_wants_a_type(tmp_path: Path) -> None:
    (tmp_path / "node.py").write_text(SAYS)
    bag = write_bag(tmp_path / "bag", scans(4), None)
    with pytest.raises(NodeError, match="a dictionary is of no type"):
        NodeCheck(NamedNode("/cmd_vel", "node.py:Untyped", tmp_path)).record_anew(bag)
    check = NodeCheck(NamedNode("/cmd_vel", "node.py:Standing", tmp_path))
    check.record_anew(bag)
    said = [m for m in MessageFile(bag).messages() if m.stream.topic == "/cmd_vel"]
    assert [Twist.deserialize(m.payload).linear.x for m in said] == [0.25] * 4
    assert check.report(bag).is_same


def test_a_missing_message_is_named_after_it_was_recorded_once(tmp_path: Path) -> None:
    write_project(tmp_path, "", double=DOUBLE.replace("= 2", "= 3"))
    log = doubled(tmp_path / "logs/json.mcap")
    NodeCheck(NamedNode("/out", "double.py:Double", tmp_path)).record_anew(log)
    lazy = DOUBLE.replace("= 2", "= 3").replace('== "/in"', '== "/in" and message != 7')
    write_project(tmp_path, "", double=lazy)
    report = NodeCheck(NamedNode("/out", "double.py:Double", tmp_path)).report(log)
    assert report.found is not None
    assert (report.found.align, report.found.identical, report.found.only_a) == (
        "publish-time",
        19,
        1,
    )
    assert "only recorded: 1, the first message 7" in str(report)
