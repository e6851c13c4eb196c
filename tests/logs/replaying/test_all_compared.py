"""What a log holds is compared, or the report says that it was not."""

from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.container.run_info import RUN as RUN_METADATA
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.replaying.report import ReplayReport
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Command, Decision, Tick
from reflexarc_runtime.policy.policy import load_policy
from support.merging import merge
from support.policies import exported
from support.recordings import CONTRACT, START_NS, drive, nominal
from support.rewriting import edit_decisions, rewrite

COMMAND = "/robot0/command"


def second_is_robot1(number: int, topic: str) -> str:
    return topic.replace("/robot0/", "/robot1/") if number else topic


def faster(topic: str, nth: int, payload: bytes) -> bytes:
    if topic != COMMAND or nth < 40:
        return payload
    command = Command.FromString(payload)
    command.linear_mps = 9.0
    return command.SerializeToString()


def wrong_values(topic: str, nth: int, payload: bytes) -> bytes:
    if not topic.endswith("/tick"):
        return payload
    tick = Tick.FromString(payload)
    for i in range(len(tick.decision.q_values)):
        tick.decision.q_values[i] += 1.0
    return tick.SerializeToString()


def uses(report: ReplayReport) -> dict[str, str]:
    return {stream.topic: stream.use for stream in report.streams}


def test_every_command_is_compared_with_its_tick(log_path):
    (commands,) = replay(log_path).commands
    assert (commands.recorded, commands.compared, commands.identical) == (61, 61, 61)
    assert commands.ticks_without == commands.without_tick == commands.of_others == 0


@pytest.mark.parametrize("level", [None, "policy", "node"])
def test_a_command_that_is_not_its_ticks_is_different_at_any_level(level, log_path, tmp_path):
    report = replay(rewrite(log_path, tmp_path / "log.mcap", faster), level=level)
    (commands,) = report.commands
    assert report.exit_status == 1
    assert (commands.compared, commands.identical) == (61, 40)
    assert commands.first is not None
    assert (commands.first.tick, commands.first.path) == (40, "sent.linear_mps")
    assert commands.first.replayed == "9.0"
    assert "sent.linear_mps" in str(report)
    assert "sent.linear_mps" in repr(report)


def test_commands_that_are_missing_are_said_and_never_different(log_path, tmp_path):
    def without(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic == COMMAND and 10 <= nth < 15 else payload

    report = replay(rewrite(log_path, tmp_path / "log.mcap", without))
    assert report.exit_status == 0
    assert report.notes == ("5 ticks have no recorded command beside them",)
    none = rewrite(
        log_path, tmp_path / "none.mcap", lambda topic, _, p: None if topic == COMMAND else p
    )
    assert replay(none).notes == ("no commands were recorded beside the ticks: none was compared",)


def test_a_command_whose_tick_is_missing_is_said(log_path, tmp_path):
    def without(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic.endswith("/tick") and nth == 20 else payload

    report = replay(rewrite(log_path, tmp_path / "log.mcap", without))
    assert report.exit_status == 0
    assert "1 commands have no tick: not compared" in report.notes
    assert "1 ticks are missing, the first is tick 20" in report.notes


def test_a_listener_hears_a_watchdog_whose_commands_are_not_the_loops(policy, tmp_path):
    watchdog = Command(sequence=5, action=-1, verdict="OVERRUN").SerializeToString()
    stamp = pack_stamp(Stamp(0, START_NS))
    encoding = protobuf_encoding("reflexarc.Command")
    said = Message("robot0/command", watchdog, encoding, stamp, START_NS)
    path = tmp_path / "log.mcap"
    drive(path, policy, nominal(20), 20, before=[said])
    heard = replay(rewrite_run(path, tmp_path / "heard.mcap", recorded_by="record"))
    (commands,) = heard.commands
    assert heard.exit_status == 0
    assert (commands.compared, commands.identical, commands.of_watchdog) == (21, 21, 1)
    assert "1 commands have no tick: not compared" in replay(path).notes


def rewrite_run(path: Path, out: Path, **fields: str) -> Path:
    return rewrite(path, out, metadata={RUN_METADATA: fields})


def test_two_robots_of_a_merged_log_are_both_replayed(log_path, tmp_path):
    merged = merge([log_path, log_path], tmp_path / "log.mcap", rename=second_is_robot1)
    report = replay(merged)
    assert report.exit_status == 0
    assert [(level.level, level.robot, level.identical) for level in report.levels] == [
        ("policy", "", 58),
        ("node", "", 61),
        ("policy", "robot1", 58),
        ("node", "robot1", 61),
    ]
    assert [commands.identical for commands in report.commands] == [61, 61]
    assert uses(report)["/robot1/retina"] == "input"


@pytest.mark.parametrize("with_heads", [True, False])
def test_a_second_robot_that_differs_is_found_whatever_the_log_says_of_it(
    with_heads, log_path, tmp_path
):
    wrong = rewrite(log_path, tmp_path / "wrong.mcap", wrong_values)
    logs, out = [log_path, wrong], tmp_path / "log.mcap"
    report = replay(merge(logs, out, rename=second_is_robot1, with_heads=with_heads))
    assert report.exit_status == 1
    (found,) = [x for x in report.levels if (x.level, x.robot) == ("policy", "robot1")]
    assert (found.compared, found.identical) == (58, 0)
    left_out = "robot1: level node was left out: the log does not say how its loop ran"
    assert (left_out in report.notes) is not with_heads


def test_a_second_robot_of_another_policy_that_is_not_there_is_said(log_path, tmp_path):
    other = tmp_path / "other.mcap"
    drive(other, exported(CONTRACT, seed=9), nominal(30), 30)
    logs, out = [log_path, other], tmp_path / "log.mcap"
    report = replay(merge(logs, out, rename=second_is_robot1, with_heads=False))
    assert report.exit_status == 0
    (note,) = report.notes
    assert note.startswith("robot1: 31 ticks were not compared: their policy (")


def test_a_second_robot_of_another_policy_that_is_there_is_compared(log_path, tmp_path):
    other = tmp_path / "other.mcap"
    drive(other, exported(CONTRACT, seed=9), nominal(30), 30)
    report = replay(merge([log_path, other], tmp_path / "log.mcap", rename=second_is_robot1))
    assert report.exit_status == 0
    assert [level.identical for level in report.levels] == [58, 61, 28, 31]


@pytest.mark.parametrize("length", [30, 60, 90])
def test_two_runs_of_one_robot_are_compared_at_level_policy_and_said(length, log_path, tmp_path):
    other = tmp_path / "other.mcap"
    drive(other, read_log(log_path).policy or b"", nominal(length, 5), length)
    report = replay(merge([log_path, other], tmp_path / "log.mcap"))
    assert report.exit_status == 0
    (level,) = report.levels
    assert level.compared == 58 + length - 2
    assert "level node was left out: it holds the ticks of more than one run: a merged log" in (
        report.notes
    )


def test_a_log_merged_with_itself_is_not_different(log_path, tmp_path):
    report = replay(merge([log_path, log_path], tmp_path / "log.mcap"))
    assert report.exit_status == 0
    assert any("twice" in note for note in report.notes)


def test_a_topic_that_decides_nothing_is_said_to_be_not_compared(policy, tmp_path):
    stamp = pack_stamp(Stamp(0, START_NS))
    said = [
        Message(f"robot0/{name}", b"", protobuf_encoding(f"reflexarc.{kind}"), stamp, START_NS)
        for name, kind in (("status", "Status"), ("lease", "Lease"))
    ]
    drive(tmp_path / "log.mcap", policy, nominal(9), 9, before=said)
    report = replay(tmp_path / "log.mcap")
    assert uses(report) == {
        "/robot0/command": "compared",
        "/robot0/keyframe": "compared",
        "/robot0/lease": "not compared",
        "/robot0/retina": "input",
        "/robot0/status": "not compared",
        "/robot0/stop": "input",
        "/robot0/tick": "compared",
    }
    assert "  not compared: /robot0/lease, /robot0/status" in report.lines()
    assert report.as_dict()["streams"][2]["use"] == "not compared"


def test_inputs_that_no_level_used_are_said_to_be_not_compared(log_path, tmp_path):
    path = rewrite_run(log_path, tmp_path / "log.mcap", recorded_by="record")
    assert uses(replay(path))["/robot0/retina"] == "not compared"


GAPS = [range(30, 31), range(30, 37), range(1, 4), range(50, 60)]


@pytest.mark.parametrize("lost", GAPS, ids=str)
@pytest.mark.parametrize("topics", [("tick",), ("retina",), ("tick", "retina"), ("keyframe",)])
@pytest.mark.parametrize("hold_s", [0.0, 0.1])
def test_whatever_is_missing_in_the_middle_nothing_is_different(hold_s, topics, lost, tmp_path):
    path = tmp_path / "log.mcap"
    contract = replace(CONTRACT, hold_s=hold_s)
    drive(path, exported(contract, 3, "Relu"), nominal(120), 120)

    def without(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic.rpartition("/")[2] in topics and nth in lost else payload

    report = replay(rewrite(path, tmp_path / "part.mcap", without))
    assert report.exit_status == 0, report.lines()
    node = report.levels[1]
    if "retina" in topics or "tick" in topics:
        assert any("missing" in note for note in report.notes)
    assert node.compared > 50  # it goes on behind what is missing
    assert node.compared == node.identical


def test_a_difference_behind_what_is_missing_is_found(log_path, tmp_path):
    def edit(topic: str, nth: int, payload: bytes) -> bytes | None:
        if not topic.endswith("/tick"):
            return payload
        return None if nth in range(20, 25) else wrong_values(topic, nth, payload)[:None]

    def late(topic: str, nth: int, payload: bytes) -> bytes | None:
        if not topic.endswith("/tick") or nth < 50:
            return None if topic.endswith("/tick") and nth in range(20, 25) else payload
        tick = Tick.FromString(payload)
        tick.decision.reason = "no"
        return tick.SerializeToString()

    node = replay(rewrite(log_path, tmp_path / "log.mcap", late)).levels[1]
    assert node.first is not None
    assert (node.first.tick, node.first.path) == (50, "reason")


def test_a_log_that_ends_before_its_loop_did_says_so(log_path, tmp_path):
    def first_half(topic: str, nth: int, payload: bytes) -> bytes | None:
        return payload if nth < 30 or not topic.endswith(("tick", "command", "stop")) else None

    report = replay(rewrite(log_path, tmp_path / "log.mcap", first_half))
    assert report.exit_status == 0
    assert "it holds ticks 0 to 29: what came after is not in it" in report.notes


FAR_NS = (1 << 64) - (1 << 62)


@pytest.mark.parametrize("what", ["shifted", "saturated"])
def test_times_beyond_what_a_clock_can_say_leave_level_node_out(what, log_path, tmp_path):
    path = shifted(log_path, tmp_path / "log.mcap", saturate=what == "saturated")
    report = replay(path)
    assert report.exit_status == 0
    assert [level.level for level in report.levels] == ["policy"]
    assert any("level node was left out" in note for note in report.notes)
    with pytest.raises(LogError, match="no replay at level node") as caught:
        replay(path, level="node")
    assert "\n" not in str(caught.value)


def shifted(log: Path, out: Path, *, saturate: bool) -> Path:
    """The log with all times near 2^64."""
    from mcap.writer import Writer

    from support import rewriting

    class Far(Writer):
        def add_message(self, channel_id, log_time, data, publish_time, sequence=0):  # type: ignore[no-untyped-def]
            late = [(1 << 64) - 1 if saturate else FAR_NS + t for t in (log_time, publish_time)]
            super().add_message(channel_id, late[0], data, late[1], sequence)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rewriting, "Writer", Far)
        return rewriting.rewrite(log, out)


def test_a_pointer_of_git_lfs_is_named_as_such(tmp_path):
    path = tmp_path / "log.mcap"
    path.write_text("version https://git-lfs.github.com/spec/v1\noid sha256:12\nsize 3\n")
    with pytest.raises(LogError, match=r"is a Git LFS pointer, .*`git lfs pull`"):
        replay(path)


def test_what_the_log_gives_and_nothing_tells_twice_is_named(log_path):
    policy, node = replay(log_path).levels
    assert policy.given == ("slot", "retina", "state")
    assert node.given == ("slot", "now_ns")


def test_keyframes_are_not_compared_with_what_another_policy_knows(log_path):
    report = replay(log_path, policy=load_policy(exported(CONTRACT, seed=9)))
    assert uses(report)["/robot0/keyframe"] == "not compared"
    assert uses(report)["/robot0/retina"] == "input"


def test_ticks_without_the_values_that_they_must_have_are_said(log_path, tmp_path):
    def without(decision: Decision) -> None:
        if decision.index == 30:
            del decision.q_values[:]

    report = replay(
        rewrite(log_path, tmp_path / "log.mcap", edit_decisions(without)), level="policy"
    )
    assert report.levels[0].compared == 57
    assert report.notes == ("1 ticks hold no Q-values, though the policy was asked",)
