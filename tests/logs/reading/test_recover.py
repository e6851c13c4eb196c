import contextlib
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from mcap.records import Chunk

from reflexarc_logs.container import writing as log_file
from reflexarc_logs.container.record_stream import stream_records
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.recording.scribe import FLUSH_PERIOD_S
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError
from support.recordings import RUN, drive, nominal
from support.rewriting import flip_bit

TESTS = Path(__file__).parents[2]

VICTIM = """
import sys, time
sys.path.insert(0, sys.argv[2])
import numpy as np
from pathlib import Path
from support.recordings import RUN, retina_at
from reflexarc_logs.recording.recorder import Recorder

partial = Path(sys.argv[1] + ".partial")
recorder = Recorder(sys.argv[1], RUN, b"", {}, wall_offset_ns=0)
for slot in range(500):
    recorder.put(retina_at(slot, np.zeros((1, 16, 1), np.uint8)))
sizes = [0, partial.stat().st_size]
while sizes[-1] != sizes[-2] or len(sizes) < 4:  # until nothing is left to be flushed
    time.sleep(1.0)
    sizes.append(partial.stat().st_size)
for slot in range(500, 700):
    recorder.put(retina_at(slot, np.zeros((1, 16, 1), np.uint8)))
print("kill me", flush=True)
time.sleep(60)
"""


def test_a_recording_killed_outright_loses_only_what_was_not_yet_flushed(tmp_path):
    path, fixed = tmp_path / "log.mcap", tmp_path / "fixed.mcap"
    arguments = [sys.executable, "-c", VICTIM, str(path), str(TESTS)]
    with subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True) as victim:
        assert victim.stdout is not None
        assert victim.stdout.readline() == "kill me\n"
        victim.send_signal(signal.SIGKILL)
    assert not path.exists()
    recovered = recover(tmp_path / "log.mcap.partial", fixed)
    log = read_log(fixed)
    assert recovered.messages >= 500
    assert [r.sequence for r in log.records()] == list(range(recovered.messages))
    assert log.run.run_id == RUN.run_id


def test_the_flush_period_keeps_the_promise_of_losing_less_than_a_second():
    assert FLUSH_PERIOD_S <= 0.8  # a fifth of a second for a busy machine and for compressing


def test_a_log_cut_anywhere_is_recovered_to_a_log_that_replays(log_path, tmp_path):
    data, whole = log_path.read_bytes(), list(read_log(log_path).records())
    recovered_any = 0
    head = data.index(b'rate_hz": 50.0\n}') + 20  # the attachments end here
    for size in range(head, len(data), 3000):
        cut, fixed = tmp_path / f"{size}.mcap", tmp_path / f"{size}-fixed.mcap"
        cut.write_bytes(data[:size])
        recovered = recover(cut, fixed)
        part = list(read_log(fixed).records())
        assert part == whole[: recovered.messages]
        assert read_log(fixed).attachments == read_log(log_path).attachments
        if any(record.topic == "/robot0/tick" for record in part):
            assert replay(fixed).exit_status == 0
            recovered_any += 1
    assert recovered_any > 3


def test_the_bytes_after_the_last_intact_record_are_counted_as_lost(log_path, tmp_path):
    data, sizes = log_path.read_bytes(), []
    for size in range(9000, 9400, 50):
        cut, fixed = tmp_path / f"{size}.mcap", tmp_path / f"{size}-fixed.mcap"
        cut.write_bytes(data[:size])
        recovered = recover(cut, fixed)
        sizes.append(size - recovered.lost_bytes)
    assert all(0 < kept <= 9400 for kept in sizes)
    assert sizes == sorted(sizes)


def test_inputs_after_the_last_tick_are_kept_and_counted(policy, tmp_path, monkeypatch):
    monkeypatch.setattr(log_file, "CHUNK_BYTES", 50)  # one message each
    drive(tmp_path / "log.mcap", policy, nominal(40), 40)
    data, notes = (tmp_path / "log.mcap").read_bytes(), set()
    for size in range(6000, len(data), 570):
        cut, fixed = tmp_path / f"{size}.mcap", tmp_path / f"{size}-fixed.mcap"
        cut.write_bytes(data[:size])
        recover(cut, fixed)
        with contextlib.suppress(LogError):  # so short that there is no tick yet
            notes |= set(replay(fixed).notes)
    ends = {note for note in notes if "what came after is not in it" in note}
    commands = {note for note in notes if "command" in note}
    assert notes - ends - commands == {"1 inputs after the last tick"}
    assert len(ends) > 10


def test_recovering_a_finished_log_changes_nothing_and_says_so(log_path, tmp_path):
    recovered = recover(log_path, tmp_path / "copy.mcap")
    assert recovered.was_complete
    assert (recovered.lost_bytes, recovered.damaged_chunks) == (0, 0)
    assert list(read_log(recovered.path).records()) == list(read_log(log_path).records())


def test_a_damaged_chunk_is_left_out_and_the_log_says_that_something_is_missing(log_path, tmp_path):
    data = log_path.read_bytes()
    broken, fixed = tmp_path / "broken.mcap", tmp_path / "fixed.mcap"
    chunks = [r for r in stream_records(log_path) if isinstance(r.record, Chunk)]
    broken.write_bytes(flip_bit(data, chunks[len(chunks) // 2].end - 20))
    with pytest.raises(LogError, match="damaged"):
        read_log(broken)
    recovered = recover(broken, fixed)
    assert recovered.damaged_chunks == 1
    assert not recovered.was_complete
    assert recovered.lost_bytes > 0
    whole = list(read_log(log_path).records())
    kept = list(read_log(fixed).records())
    assert len(whole) - 60 < len(kept) < len(whole)
    assert [record for record in whole if record in kept] == kept
    report = replay(fixed)
    assert report.exit_status == 0
    assert [level.level for level in report.levels] == ["policy"]
    assert "missing in its middle" in report.notes[0]


def test_a_partial_log_is_recovered_to_the_name_that_it_was_to_have(log_path, tmp_path):
    partial = tmp_path / "log.mcap.partial"
    partial.write_bytes(log_path.read_bytes()[:20_000])
    recover(partial, tmp_path / "log.mcap")
    assert replay(tmp_path / "log.mcap").exit_status == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["log.mcap", "log.mcap.partial"]


def test_a_recovery_never_overwrites(log_path, tmp_path):
    (tmp_path / "fixed.mcap").write_bytes(b"precious")
    with pytest.raises(LogError, match="exists already"):
        recover(log_path, tmp_path / "fixed.mcap")
    assert (tmp_path / "fixed.mcap").read_bytes() == b"precious"


def test_a_recovery_that_fails_leaves_nothing_behind(log_path, tmp_path, monkeypatch):
    def no_room(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("reflexarc_logs.container.raw_log.RawLog.chunk", no_room)
    with pytest.raises(LogError, match="cannot be written: No space left on device"):
        recover(log_path, tmp_path / "fixed.mcap")
    monkeypatch.setattr("reflexarc_logs.container.raw_log.RawLog.chunk", lambda *_, **__: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        recover(log_path, tmp_path / "fixed.mcap")
    assert not list(tmp_path.iterdir())
