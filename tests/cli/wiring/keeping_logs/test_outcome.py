"""What a command says of its recording."""

from pathlib import Path

import pytest

from reflexarc.wiring.keeping_logs.outcome import Recording, recording_of
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_runtime.loop.sink import NoSink
from support.recordings import RUN

A, B, C = Path("a.mcap"), Path("a.part2.mcap"), Path("a.part10.mcap")


@pytest.mark.parametrize(
    ("recording", "words"),
    [
        (Recording("off"), "off"),
        (Recording("off", (A,)), "a.mcap"),
        (Recording("off, 7 records dropped", (A,), True), "a.mcap, 7 records dropped"),
        (Recording("off, again in B", (A, B), True), "a.mcap, a.part2.mcap, again in B"),
        (Recording("off", (A, *[B] * 8, C)), "a.mcap … a.part10.mcap (10 parts)"),
        (Recording("stopped: No space", (A,), True), "stopped: No space (a.mcap)"),
        (Recording("stopped: the file was deleted", (), True), "stopped: the file was deleted"),
    ],
)
def test_a_person_reads_where_it_is_and_what_is_amiss(recording, words):
    assert recording.in_words == words


def test_nothing_was_recorded_and_nothing_failed():
    assert recording_of(NoSink()) == Recording("off")


def test_a_recording_whose_file_was_deleted_failed_and_has_no_parts(tmp_path):
    path = tmp_path / "a.mcap"
    with Recorder(path, RUN, b"", {}, wall_offset_ns=0) as recorder:
        (tmp_path / "a.mcap.partial").unlink()
    # It was closed before the next look: the end itself finds out.
    assert recording_of(recorder).failed
    assert recording_of(recorder).parts == ()
