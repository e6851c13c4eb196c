"""Parts of logs replay by themselves: cut by ours, and sliced by another tool."""

import random
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.cutting.cut import cut
from reflexarc_logs.cutting.span import TickSpan, span_of
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.messages.topics import KEYFRAME
from support.policies import exported
from support.recordings import CONTRACT, FAULT_STALLS, RUN, drive, faults, nominal
from support.slices import slice_by_time, times_ns

HELD = replace(CONTRACT, hold_s=0.12, margin=0.1)
STACKED = replace(CONTRACT, retina=replace(CONTRACT.retina, frames=3))
TICKS = 260
GOLDEN = Path(__file__).parents[2] / "golden"


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Drives with faults: of a plain reflex, of one that sees three frames, of one that holds."""
    folder = tmp_path_factory.mktemp("drives")
    contracts = {"plain": CONTRACT, "stacked": STACKED, "held": HELD}
    for name, contract in contracts.items():
        policy = exported(contract, 3, "Relu")
        drive(folder / f"{name}.mcap", policy, faults(300), TICKS, stalls=FAULT_STALLS)
    return {name: folder / f"{name}.mcap" for name in contracts}


def decisions(log: Log, first: int, end: int) -> list[bytes]:
    ticks = (tick.decision for tick in log.ticks())
    return [d.SerializeToString() for d in ticks if first <= d.index < end]


@pytest.mark.parametrize("name", ["plain", "stacked", "held"])
def test_any_part_replays_at_both_levels_and_holds_the_same_ticks(name, logs, tmp_path):
    whole, dice = read_log(logs[name]), random.Random(name)
    for number in range(12):
        first = dice.randrange(TICKS)
        end = dice.randrange(first + 1, TICKS + 2)
        part = cut(whole, TickSpan(first, end), tmp_path / f"{number}.mcap")
        report = replay(part.path)
        assert (report.exit_status, part.ticks) == (0, end - first), (first, end, report.lines())
        node = next(level for level in report.levels if level.level == "node")
        assert node.compared == end - first
        assert decisions(read_log(part.path), 0, 999) == decisions(whole, first, end)


@pytest.mark.parametrize("name", ["plain", "stacked", "held"])
def test_any_slice_of_another_tool_replays_at_both_levels(name, logs, tmp_path):
    dice = random.Random(name)
    earliest_ns, latest_ns = times_ns(logs[name])
    for number in range(12):
        first_ns = dice.randrange(earliest_ns, latest_ns - 1_500_000_000)
        end_ns = dice.randrange(first_ns + 1_400_000_000, latest_ns + 1)
        part = slice_by_time(logs[name], tmp_path / f"{number}.mcap", first_ns, end_ns)
        report = replay(part)
        assert report.exit_status == 0, (first_ns, end_ns, report.lines())
        assert [level.level for level in report.levels] == ["policy", "node"]
        assert all(level.compared > 0 for level in report.levels)


def test_a_slice_says_what_was_left_out(logs, tmp_path):
    earliest_ns, latest_ns = times_ns(logs["held"])
    part = slice_by_time(
        logs["held"], tmp_path / "part.mcap", earliest_ns + 2_500_000_000, latest_ns
    )
    note = replay(part).notes[0]
    assert note.startswith("level node begins behind tick ")
    assert "ticks before were left out" in note


def test_a_slice_that_tells_nothing_is_left_out_with_the_reason(logs, tmp_path):
    earliest_ns, _ = times_ns(logs["held"])
    first_ns = earliest_ns + 2_100_000_000  # behind the keyframe of second 2
    part = slice_by_time(logs["held"], tmp_path / "part.mcap", first_ns, first_ns + 500_000_000)
    report = replay(part)
    assert report.exit_status == 0
    node = report.levels[1]
    assert (node.ticks > 20, node.compared) == (True, 0)
    assert "slice without a keyframe" in report.notes[0]
    assert replay(part, level="node").exit_status == 2


@pytest.mark.parametrize("name", ["nominal", "drive", "faults-live"])
def test_a_slice_of_an_old_log_begins_behind_its_first_good_tick(name, tmp_path):
    """Where no arrivals crossed on their way to the loop, which since then they cannot."""
    old = GOLDEN / "museum" / "schema-2" / f"{name}.mcap"
    earliest_ns, latest_ns = times_ns(old)
    half_ns = (earliest_ns + latest_ns) // 2
    report = replay(slice_by_time(old, tmp_path / "part.mcap", half_ns, latest_ns + 1))
    assert report.exit_status == 0
    assert [level.compared > 50 for level in report.levels] == [True, True]


def test_an_old_log_is_cut_with_a_keyframe(tmp_path):
    old = read_log(GOLDEN / "museum" / "schema-2" / "faults.mcap")
    part = cut(old, TickSpan(100, 200), tmp_path / "part.mcap")
    assert part.has_keyframe
    assert replay(part.path).exit_status == 0
    assert read_log(part.path).run == old.run


def test_a_part_of_a_part_replays(logs, tmp_path):
    part = cut(read_log(logs["held"]), TickSpan(50, 200), tmp_path / "part.mcap")
    again = cut(read_log(part.path), TickSpan(120, 150), tmp_path / "again.mcap")
    report = replay(again.path)
    assert report.exit_status == 0
    assert report.levels[1].compared == 30


def test_one_keyframe_stands_at_the_beginning_whatever_stood_there(logs, tmp_path):
    whole = read_log(logs["plain"])
    topic = whole.topic(KEYFRAME.name)
    indices = [record.sequence for record in whole.records(topic)]
    at = indices[2]  # a keyframe of the recording stands right there
    part = read_log(cut(whole, TickSpan(at, at + 5), tmp_path / "part.mcap").path)
    records = list(part.records())
    assert records[0].topic == topic
    assert [r.sequence for r in records if r.topic == topic] == [at]


def test_a_log_of_a_listener_is_cut_without_a_keyframe_and_says_so(tmp_path):
    log = read_log(GOLDEN / "museum" / "schema-2" / "listener.mcap")
    first = next(log.ticks()).decision.index
    part = cut(log, TickSpan(first + 10, first + 20), tmp_path / "part.mcap")
    assert not part.has_keyframe
    assert "recorded by a listener" in part.notes[0]
    assert replay(part.path).exit_status == 0


def test_a_part_of_a_log_that_replays_differently_says_so(logs, tmp_path):
    from support.rewriting import edit_decisions, rewrite

    def lie(decision):
        if decision.index == 20:
            decision.reason = "no"

    path = rewrite(logs["plain"], tmp_path / "lie.mcap", edit_decisions(lie))
    part = cut(read_log(path), TickSpan(30, 60), tmp_path / "part.mcap")
    assert "1 ticks replay differently" in part.notes[0]
    assert replay(part.path).exit_status == 0


def test_a_killed_cut_leaves_nothing_and_never_writes_over_a_log(logs, tmp_path):
    out = tmp_path / "part.mcap"
    out.write_bytes(b"mine")
    with pytest.raises(LogError, match="exists already"):
        cut(read_log(logs["plain"]), TickSpan(0, 10), out)
    assert out.read_bytes() == b"mine"
    assert [path.name for path in tmp_path.iterdir()] == ["part.mcap"]


@pytest.mark.parametrize(
    ("since", "until", "first", "end"),
    [
        ("", "", 0, 41),
        ("7", "9", 7, 9),
        ("0s", "0.1s", 0, 5),
        ("0.11s", "", 6, 41),
        ("3", "900", 3, 41),
    ],
)
def test_a_span_is_ticks_or_seconds(since, until, first, end, tmp_path):
    drive(tmp_path / "log.mcap", exported(CONTRACT, 3, "Relu"), nominal(40), 40, run=RUN)
    assert span_of(read_log(tmp_path / "log.mcap"), since, until) == TickSpan(first, end)


@pytest.mark.parametrize(
    ("since", "until"), [("9", "9"), ("9", "3"), ("x", ""), ("nans", ""), ("-3", ""), ("-1s", "")]
)
def test_a_span_that_is_none_is_refused(since, until, logs):
    with pytest.raises(UsageError, match=r"--from|--to"):
        span_of(read_log(logs["plain"]), since, until)
