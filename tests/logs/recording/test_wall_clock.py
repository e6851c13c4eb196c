"""A wall clock that is set is noticed once, and a slow drift only once it is worth a word."""

import time

from foxglove_schemas_protobuf.Log_pb2 import Log

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.recording import scribe as scribe_module
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.recording.wall_clock import WallClock, offset_ns
from support.recordings import RUN, nominal

MS = 1_000_000


def looks_at(*offsets_ms: float) -> list[str]:
    offsets = iter(round(offset * MS) for offset in offsets_ms)
    clock = WallClock(lambda: next(offsets))
    return [clock.look() for _ in offsets_ms[1:]]


def test_a_step_is_said_once_with_its_size_and_the_sum():
    first, second, third, fourth = looks_at(1000, 1000, 4500, 4500, 500)
    assert (first, third) == ("", "")
    assert "went +3.500 s" in second
    assert "+3.500 s since" in second
    assert "went -4.000 s" in fourth
    assert "-0.500 s since" in fourth


def test_readings_that_jitter_are_no_step():
    assert looks_at(0, 20, -20, 49, -49) == [""] * 4


def test_a_drift_is_said_each_time_it_has_grown_by_a_step():
    said = looks_at(*range(0, 200, 10))
    assert [bool(words) for words in said] == [i % 5 == 0 for i in range(1, 20)]


def test_the_offset_turns_the_monotonic_clock_into_the_wall_clock():
    assert abs(time.monotonic_ns() + offset_ns() - time.time_ns()) < 1_000_000_000


def test_a_step_stands_in_the_log_where_it_was_noticed(tmp_path, monkeypatch):
    offsets = iter([0, 0, *[-7_200_000 * MS] * 1000])
    monkeypatch.setattr(scribe_module, "WallClock", lambda: WallClock(lambda: next(offsets)))
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.02)
    messages = [message for batch in nominal(100).values() for message in batch]
    with Recorder(tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=5) as recorder:
        for message in messages:
            recorder.put(message)
            time.sleep(0.002)
    log = read_log(tmp_path / "a.mcap")
    ((record, said),) = log.messages("/robot0/log", Log)
    assert said.level == Log.WARNING
    assert said.name == "recorder"
    assert said.message.startswith("the wall clock went -7200.000 s")
    times = [r.log_ns for r in log.records()]
    assert times == sorted(times)
    assert record.log_ns in {message.received_ns + 5 for message in messages}


def test_drops_are_said_where_they_happened(tmp_path, monkeypatch):
    monkeypatch.setattr(scribe_module, "FLUSH_PERIOD_S", 0.02)
    first, *_, last = [message for batch in nominal(10).values() for message in batch]
    with Recorder(tmp_path / "a.mcap", RUN, b"", {}, wall_offset_ns=0) as recorder:
        recorder.put(first)
        time.sleep(0.1)
        recorder._backlog.dropped += 3
        time.sleep(0.1)
        recorder.put(last)
    topics = [r.topic.rpartition("/")[2] for r in read_log(tmp_path / "a.mcap").records()]
    assert topics == ["retina", "log", "retina"]
    ((_, said),) = read_log(tmp_path / "a.mcap").messages("/robot0/log", Log)
    assert said.message == "3 records dropped: the disk is too slow"
