"""A black box: what makes it write, what it writes, and that each of its logs replays by itself."""

import shutil
import time
from dataclasses import replace
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.Log_pb2 import Log

from reflexarc_logs.container.first_look import look
from reflexarc_logs.container.manifest import read_manifest
from reflexarc_logs.container.rejected import LogEntry
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.recording import black_box as black_box_module
from reflexarc_logs.recording import scribe as scribe_module
from reflexarc_logs.recording.black_box import BlackBox, BoxSpan
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.recording.part import PART
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.recording.ring import ENTRY_BYTES, Ring
from reflexarc_logs.recording.triggers import Triggers
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.loop.node import END_OF_RUN
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.topics import CONTACT, MARK, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Contact, Decision, Keyframe, Tick
from support.bad_disks import Disks, full_after
from support.policies import exported
from support.recordings import CONTRACT, MS, RUN, drive, faults, nominal

SECOND_NS = 1000 * MS
SPAN = BoxSpan(before_s=2.0, after_s=1.0)


@pytest.fixture(scope="module")
def policy() -> bytes:
    return exported(CONTRACT, 3, "Relu")


def ticks_of(path: Path) -> list[Decision]:
    return [tick.decision for tick in read_log(path).ticks()]


def silent(schedule, first: int, last: int):
    """No retina comes in these slots."""
    return {slot: batch for slot, batch in schedule.items() if not first <= slot <= last}


def test_nothing_happens_and_nothing_is_written(policy, tmp_path):
    drive(tmp_path / "a.mcap", policy, nominal(300), 300, box=SPAN, keeping=Keeping())
    assert list(tmp_path.iterdir()) == []


def test_around_a_gap_so_much_is_written_and_it_replays_at_both_levels(policy, tmp_path):
    schedule = silent(nominal(700), 400, 430)
    drive(tmp_path / "whole.mcap", policy, schedule, 700)
    drive(tmp_path / "a.mcap", policy, schedule, 700, box=SPAN)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.mcap", "whole.mcap"]
    decisions = ticks_of(tmp_path / "a.mcap")
    whole = ticks_of(tmp_path / "whole.mcap")
    began = next(d.index for d in whole[100:] if d.verdict != Verdict.OK)
    assert 2.0 <= (began - decisions[0].index) * 0.02 <= 3.02  # a keyframe comes once a second
    assert 1.0 <= (decisions[-1].index - began) * 0.02 <= 1.1
    assert [d.index for d in decisions] == list(range(decisions[0].index, decisions[-1].index + 1))
    report = replay(tmp_path / "a.mcap")
    assert report.exit_status == 0
    assert {level.level for level in report.levels} == {"policy", "node"}
    said = look(tmp_path / "a.mcap").metadata[PART]
    assert said["trigger"].startswith("stale input: ")
    assert said["trigger"].endswith(f"(tick {began})")


def test_what_happens_again_makes_it_longer_and_later_it_is_another_log(policy, tmp_path):
    schedule = silent(silent(silent(nominal(1400), 300, 320), 345, 365), 1000, 1020)
    drive(
        tmp_path / "a.mcap", policy, schedule, 1400, box=SPAN, keeping=Keeping(keep_bytes=1 << 30)
    )
    first, second = log_paths([tmp_path / "a.parts.jsonl"])
    assert ticks_of(first)[-1].index > 345 + 50
    assert 800 < ticks_of(second)[0].index < 905
    assert [part.state for part in read_manifest(tmp_path / "a.parts.jsonl")] == ["finished"] * 2
    assert all(replay(path).exit_status == 0 for path in (first, second))


def test_a_drive_full_of_faults_replays_wherever_the_box_cut_it(policy, tmp_path):
    drive(tmp_path / "a.mcap", policy, faults(600), 600, box=BoxSpan(1.0, 0.3))
    parts = log_paths([tmp_path])
    assert len(parts) >= 2
    assert all(replay(path).exit_status == 0 for path in parts)


def test_one_that_goes_on_and_on_is_continued_in_the_next_part(policy, tmp_path, monkeypatch):
    monkeypatch.setattr(black_box_module, "MOST_PART_S", 3.0)
    schedule = nominal(600)
    for first in range(100, 600, 40):
        schedule = silent(schedule, first, first + 20)
    drive(tmp_path / "a.mcap", policy, schedule, 600, box=SPAN)
    parts = log_paths([tmp_path])
    assert len(parts) >= 3
    indices = [d.index for path in parts for d in ticks_of(path)]
    assert indices == list(range(indices[0], indices[-1] + 1))
    assert all(replay(path).exit_status == 0 for path in parts)


def test_what_was_in_memory_is_safe_from_a_kill_as_soon_as_a_box_begins(
    policy, tmp_path, monkeypatch
):
    """No flush is due by itself; what a kill would leave is what can be copied."""
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 1e6)
    left, finish = tmp_path / "left.partial", BlackBox.finish

    def killed(box: BlackBox) -> None:
        shutil.copy(tmp_path / "a.mcap.partial", left)
        finish(box)

    monkeypatch.setattr(BlackBox, "finish", killed)
    drive(tmp_path / "a.mcap", policy, silent(nominal(260), 250, 255), 260, box=SPAN)
    recover(left, tmp_path / "saved.mcap")
    kept, whole = ticks_of(tmp_path / "saved.mcap"), ticks_of(tmp_path / "a.mcap")
    began = next(d.index for d in whole if d.verdict == Verdict.STALE_INPUT)
    assert kept[0].index == whole[0].index
    assert kept[-1].index >= began


def test_a_box_that_could_not_be_written_is_written_again_with_all_that_it_holds(
    policy, tmp_path, monkeypatch
):
    monkeypatch.setattr("reflexarc_logs.recording.series.RETRY_S", 0.0)
    disks = Disks(full_after(60_000))
    monkeypatch.setattr("reflexarc_logs.container.unfinished.open_for_writing", disks)
    monkeypatch.setattr("reflexarc_logs.container.writing.CHUNK_BYTES", 4096)
    schedule = silent(nominal(700), 400, 430)
    drive(tmp_path / "a.mcap", policy, schedule, 700, box=BoxSpan(4.0, 3.0))
    second = tmp_path / "a.part2.mcap"
    assert replay(second).exit_status == 0
    assert any(d.verdict == Verdict.STALE_INPUT for d in ticks_of(second))
    assert look(second).metadata[PART]["after"] == "No space left on device"


def test_a_place_that_cannot_be_written_is_refused_at_once(tmp_path):
    (tmp_path / "a.mcap").write_bytes(b"precious")
    with pytest.raises(LogError, match="exists already"):
        Recorder(tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=0, box=SPAN)


def said_on(topic: Topic, payload: bytes, received_ns: int = 0) -> Message:
    stamp = pack_stamp(Stamp(0, received_ns))
    return Message(
        topic.key("robot0"), payload, protobuf_encoding(topic.schema), stamp, received_ns
    )


@pytest.mark.parametrize(
    ("topic", "payload", "words"),
    [
        (CONTACT, Contact(count=3).SerializeToString(), "contact 3 (tick 0)"),
        (MARK, Log(message="look here").SerializeToString(), "mark: look here (tick 0)"),
    ],
)
def test_a_contact_and_a_person_s_word_make_it_write(topic, payload, words, policy, tmp_path):
    after = [said_on(topic, payload)]
    drive(tmp_path / "a.mcap", policy, nominal(100), 100, box=SPAN, after=after)
    assert look(tmp_path / "a.mcap").metadata[PART]["trigger"] == words.replace("0)", "100)")
    assert replay(tmp_path / "a.mcap").exit_status == 0


def tick(index: int, verdict: Verdict, reason: str = "why") -> LogEntry:
    payload = Tick(decision=Decision(index=index, verdict=int(verdict), reason=reason))
    return LogEntry("robot0/tick", Tick, payload.SerializeToString(), index, 0, 0)


V = Verdict


@pytest.mark.parametrize(
    ("verdicts", "at"),
    [
        ([V.NO_INPUT, V.NO_INPUT, V.RECOVERING, V.OK, V.OK], []),
        ([V.NO_INPUT, V.OK, V.GUARDED, V.GUARDED, V.OK, V.GUARDED], [2, 5]),
        ([V.OK, V.STALE_INPUT, V.STALE_INPUT, V.NO_INPUT, V.RECOVERING, V.OK], [1, 3]),
        ([V.OK, V.GUARDED, V.STUCK, V.OVERRUN, V.TWO_SOURCES, V.POLICY_FAULT], [1, 2, 3, 4, 5]),
        ([V.STOPPED, V.STOPPED], [0]),
        ([V.INVALID_INPUT], [0]),
    ],
)
def test_a_verdict_is_news_when_it_begins(verdicts, at):
    triggers = Triggers()
    found = [i for i, verdict in enumerate(verdicts) if triggers.look(tick(i, verdict))]
    assert found == at


def test_the_end_of_a_run_is_no_news():
    triggers = Triggers()
    assert not triggers.look(tick(0, V.OK))
    assert not triggers.look(tick(1, V.STOPPED, f"stopped: {END_OF_RUN}"))


def entry(kind: type, at_ns: int, size: int = 0) -> LogEntry:
    return LogEntry("robot0/any", kind, bytes(size), 0, None, at_ns)


def test_a_ring_holds_at_least_its_span_and_less_than_a_keyframe_more():
    ring = Ring(3.0)
    for slot in range(500):
        if slot % 50 == 0:
            ring.add(entry(Keyframe, slot * 20 * MS), {})
        ring.add(entry(Tick, slot * 20 * MS), {})
        held = list(ring)
        assert held[0].kind is Keyframe
        span_ns = slot * 20 * MS - held[0].received_ns
        assert min(3 * SECOND_NS, slot * 20 * MS) <= span_ns < 4 * SECOND_NS


def test_a_ring_never_holds_more_than_its_bytes_and_begins_with_a_keyframe():
    most = 40 * (ENTRY_BYTES + 1000)
    ring = Ring(1000.0, most)
    for slot in range(300):
        ring.add(entry(Keyframe if slot % 15 == 0 else Tick, slot, 1000), {"dropped": slot})
        assert ring.size_bytes == sum(ENTRY_BYTES + len(e.payload) for e in ring) <= most
        assert next(iter(ring)).kind is Keyframe
    for slot in range(300, 400):  # no keyframe comes: nothing of it would replay
        ring.add(entry(Tick, slot, 1000), {})
    assert list(ring) == []
    assert ring.left_out is None
    ring.add(entry(Keyframe, 400), {"dropped": 7})
    assert ring.left_out == {"dropped": 7}


def test_what_was_dropped_while_it_was_in_memory_is_said_in_the_log(policy, tmp_path, monkeypatch):
    monkeypatch.setattr("reflexarc_logs.recording.scribe.FLUSH_PERIOD_S", 60.0)
    schedule = silent(nominal(300), 150, 180)
    dropped = {"n": 0}

    class Dropping(Recorder):
        def put_tick(self, record: TickRecord) -> None:
            dropped["n"] += 1
            if dropped["n"] in (2, 100):
                while self._backlog.waiting:  # it is counted where the recorder has come to
                    time.sleep(0.001)
                self._backlog.dropped += 1
            else:
                super().put_tick(record)

    monkeypatch.setattr("support.recordings.Recorder", Dropping)
    run = replace(RUN, run_id="d" * 32)
    drive(tmp_path / "a.mcap", policy, schedule, 300, run=run, box=SPAN)
    assert read_log(tmp_path / "a.mcap").dropped == 1  # the second was before its first keyframe
