import itertools
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.container.run_info import RUN as RUN_METADATA
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.container.writing import LogWriter
from reflexarc_logs.playing.player import GLANCE_NS, Player
from reflexarc_logs.playing.schedule import (
    LONELY_PERIOD_NS,
    REORDER_WINDOW_NS,
    Due,
    _in_order_of_time,
    schedule,
    survey_streams,
)
from reflexarc_logs.reading.reader import Log, Record, read_log
from reflexarc_runtime.decision import Command, Verdict
from reflexarc_runtime.errors import BusError, LogError
from reflexarc_runtime.loop import lockstep
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.messages.codec import encode_command
from reflexarc_runtime.messages.topics import POSE, SCAN, Topic
from reflexarc_runtime.messages.wire import Message
from support.recordings import CONTRACT, RUN, WALL_OFFSET_NS, drive, nominal

MS = 1_000_000
MADE = RunInfo("ab")
Sent = tuple[str, bytes, int]


def log_of(folder: Path, *records: tuple[str, object, int], run: RunInfo = MADE) -> Log:
    """A log of (topic name, message or bytes, log time)."""
    file = LogWriter(folder / "made.mcap")
    file.describe(RUN_METADATA, run.to_metadata())
    kinds = {"scan": LaserScan, "pose": PoseInFrame, "retina": RawImage, "command": PoseInFrame}
    for number, (name, message, time_ns) in enumerate(records):
        payload = message if isinstance(message, bytes) else message.SerializeToString()  # type: ignore[attr-defined]  # any message
        channel = file.channel(f"/robot0/{name}", kinds[name])
        file.add(channel, payload, sequence=number, publish_ns=time_ns, log_ns=time_ns)
    file.finish()
    return read_log(folder / "made.mcap")


def scan(number: int) -> LaserScan:
    return LaserScan(start_angle=number)


@pytest.fixture
def three(tmp_path: Path) -> Log:
    """Scans at 0, 100 and 200 ms, a pose at 250 ms, and what the runtime said."""
    return log_of(
        tmp_path,
        *(("scan", scan(k), k * 100 * MS) for k in range(3)),
        ("command", PoseInFrame(), 210 * MS),
        ("pose", PoseInFrame(), 250 * MS),
    )


class Stage:
    """A clock that oversleeps, and everything that was sent."""

    def __init__(self, oversleep_ns: int = 0, began_ns: int = 7 * MS) -> None:
        self.clock = ManualClock(began_ns, oversleep_ns)
        self.sent: list[Sent] = []

    def publish(self, topic: Topic, payload: bytes, time_ns: int) -> None:
        self.sent.append((topic.name, payload, time_ns))

    def player(self, **ears: Callable[[], bool]) -> Player:
        return Player(self.clock, self.publish, **ears)  # type: ignore[arg-type]  # by their names

    @property
    def times_ns(self) -> list[int]:
        return [time_ns for _, _, time_ns in self.sent]


def dues(log: Log, **wishes: object) -> list[tuple[int, str]]:
    found = schedule(log, survey_streams(log), **wishes)  # type: ignore[arg-type]  # by their names
    return [(due.due_ns, due.topic.name) for due in itertools.islice(found, 9)]


def test_what_the_body_said_is_due_at_its_time_and_nothing_else_is(three: Log):
    expected = [(0, "scan"), (100 * MS, "scan"), (200 * MS, "scan"), (250 * MS, "pose")]
    assert dues(three) == expected


def test_twice_the_speed_is_half_the_time(three: Log):
    assert [due for due, _ in dues(three, speed=2.0)] == [0, 50 * MS, 100 * MS, 125 * MS]


def test_a_loop_goes_on_one_mean_interval_after_the_last_message(three: Log):
    times = [due for due, _ in dues(three, loop=True)]
    once = [0, 100 * MS, 200 * MS, 250 * MS]
    assert times == [*once, *(350 * MS + t for t in once), 700 * MS]
    halved = [due for due, _ in dues(three, loop=True, speed=2.0)]
    assert halved == [t // 2 for t in times]


def test_a_single_message_loops_at_its_own_pace(tmp_path: Path):
    log = log_of(tmp_path, ("scan", scan(0), 5))
    assert [due for due, _ in dues(log, loop=True)] == [k * LONELY_PERIOD_NS for k in range(9)]


@given(st.lists(st.integers(0, 4 * REORDER_WINDOW_NS), max_size=40))
def test_records_come_in_the_order_of_time_as_far_as_the_window_reaches(times: list[int]):
    records = [(SCAN, Record("t", "s", k, t, t, b"")) for k, t in enumerate(times)]
    ordered = [record for _, record in _in_order_of_time(records)]
    assert sorted(r.sequence for r in ordered) == list(range(len(times)))
    latest = list(itertools.accumulate(times, max))
    if all(now - t <= REORDER_WINDOW_NS for now, t in zip(latest, times, strict=True)):
        assert [(r.log_ns, r.sequence) for r in ordered] == sorted(
            zip(times, range(len(times)), strict=True)
        )


def test_a_log_without_a_sensor_stream_has_nothing_to_play(tmp_path: Path):
    with pytest.raises(LogError, match="expected retinas or scans"):
        survey_streams(log_of(tmp_path, ("pose", PoseInFrame(), 0)))


def test_what_does_not_decode_is_counted_and_not_sent(tmp_path: Path):
    log = log_of(tmp_path, ("scan", scan(0), 0), ("scan", b"\xff\xff", 5), ("scan", scan(1), 9))
    assert survey_streams(log).undecodable == 1
    assert dues(log) == [(0, "scan"), (9, "scan")]


def test_every_message_is_sent_at_its_time_with_the_players_own_time(three: Log):
    stage = Stage()
    account = stage.player().play(schedule(three, survey_streams(three)))
    assert stage.times_ns == [7 * MS + t * MS for t in (0, 100, 200, 250)]
    assert [payload for _, payload, _ in stage.sent[:3]] == [
        scan(k).SerializeToString() for k in range(3)
    ]
    assert account.messages == {"scan": 3, "pose": 1}
    assert (account.loops, account.seconds) == (1, 0.25)
    assert account.lateness_max_ns == 0


def test_lateness_is_what_was_due_against_what_was_done(three: Log):
    stage = Stage(oversleep_ns=3 * MS)
    account = stage.player().play(schedule(three, survey_streams(three)))
    late = [
        t - 7 * MS - due
        for t, due in zip(stage.times_ns, (0, 100 * MS, 200 * MS, 250 * MS), strict=True)
    ]
    assert late == [0, 3 * MS, 3 * MS, 3 * MS]
    assert (account.lateness_p50_ns, account.lateness_max_ns) == (3 * MS, 3 * MS)


def test_a_pause_makes_the_rest_later_and_not_late(three: Log):
    stage = Stage()
    states = itertools.chain([False, False, *[True] * 4], itertools.repeat(False))
    account = stage.player(is_paused=lambda: next(states)).play(
        schedule(three, survey_streams(three))
    )
    held = 4 * GLANCE_NS
    assert stage.times_ns[0] == 7 * MS
    assert stage.times_ns[1:] == [7 * MS + held + t * MS for t in (100, 200, 250)]
    assert account.lateness_max_ns == 0


def test_it_stops_in_the_middle_when_asked(three: Log):
    stage = Stage()
    account = stage.player(should_stop=lambda: len(stage.sent) == 6).play(
        schedule(three, survey_streams(three), loop=True)
    )
    assert account.messages == {"scan": 5, "pose": 1}
    assert account.loops == 1


def test_it_stops_while_it_waits(three: Log):
    stage = Stage()
    account = stage.player(should_stop=lambda: stage.clock.time_ns > 60 * MS).play(
        schedule(three, survey_streams(three))
    )
    assert (account.messages, account.loops) == ({"scan": 1}, 0)


def test_in_lockstep_time_is_the_logs_and_each_scan_waits_for_its_command(tmp_path: Path):
    offset_ns = 10**18
    run = RunInfo("ab", input="scan", wall_offset_ns=offset_ns)
    log = log_of(
        tmp_path,
        ("scan", scan(0), offset_ns + 40),
        ("pose", PoseInFrame(), offset_ns + 50),
        ("scan", scan(1), offset_ns + 60),
        run=run,
    )
    streams, stage = survey_streams(log), Stage()
    events: list[object] = []
    player = Player(stage.clock, lambda *sent: events.append((sent[0].name, sent[2])))
    account = player.play_in_lockstep(
        itertools.islice(schedule(log, streams, loop=True), 5),
        streams.first_ns,
        streams.sensor,
        events.append,
    )
    once = [("scan", 40), 0, ("pose", 50), ("scan", 60), 1]
    assert events == [*once, ("scan", 80), 2, ("pose", 90)]  # 40 + length 20 + interval 20
    assert account.messages == {"scan": 3, "pose": 2}


def test_a_recorded_run_is_played_with_the_intervals_at_which_its_retinas_came(tmp_path: Path):
    from support.policies import exported

    drive(tmp_path / "run.mcap", exported(CONTRACT), nominal(20), 20, run=RUN)
    log = read_log(tmp_path / "run.mcap")
    streams = survey_streams(log)
    assert (streams.messages, streams.sensor) == (20, "retina")
    assert streams.interval_ns == 20 * MS
    assert dues(log) == [(k * 20 * MS, "retina") for k in range(9)]
    arrivals = [r.log_ns for r in log.records("/robot0/retina")]
    assert streams.first_ns == arrivals[0] - WALL_OFFSET_NS


def command(number: int) -> Message:
    payload = encode_command(Command(number, -1, Verdict.STALE_INPUT, 0.0, 0.0, 0.0))
    return Message("robot0/command", payload, "", b"", 0)


def test_a_body_in_lockstep_hears_every_command_up_to_the_one_that_it_waits_for():
    inbox, heard = Inbox(), []
    said = (command(3), Message("k", b"\xff", "", b"", 0), command(4), command(5))
    for message in said:
        inbox.put(message)
    lockstep.await_command(inbox, 4, heard.append, lambda: False)
    assert heard == [*said[:3]]


def test_a_body_in_lockstep_gives_up_in_the_end(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(lockstep, "PATIENCE_S", 0.01)
    with pytest.raises(BusError, match="no command for sensor message 7"):
        lockstep.await_command(Inbox(), 7, lambda said: None, lambda: False)


def test_a_body_in_lockstep_waits_no_longer_when_asked_to_stop():
    asked = threading.Event()
    asked.set()
    lockstep.await_command(Inbox(), 7, lambda said: None, asked.is_set)
    lockstep.wait_for_runtime(Inbox(), lambda: False, asked.is_set)


def test_every_due_message_is_told_of(three: Log):
    told: list[Due] = []
    stage = Stage()
    Player(stage.clock, stage.publish, saw=told.append).play(schedule(three, survey_streams(three)))
    assert [due.topic for due in told] == [SCAN, SCAN, SCAN, POSE]
