"""Behind is who has had something to do for long, by a clock that is moved by hand."""

import time

import pytest

from reflexarc_logs.recording.progress import Progress


@pytest.fixture
def clock(monkeypatch):
    now = {"s": 100.0}
    monkeypatch.setattr(time, "monotonic", lambda: now["s"])
    return now


def test_whoever_waits_for_work_is_not_behind_however_long(clock):
    progress = Progress()
    progress.work()
    progress.rest()
    clock["s"] += 60.0
    assert progress.behind_in_words(0) == ""


def test_work_without_a_rest_is_behind_since_its_beginning(clock):
    progress = Progress()
    for _ in range(20):
        progress.work()
        clock["s"] += 0.1
    assert progress.behind_in_words(7) == "the disk is slow: busy for 2.0 s, 7 records wait"
    progress.rest()
    progress.work()
    assert progress.behind_in_words(7) == ""


def test_every_step_is_progress(clock):
    progress = Progress()
    progress.work()
    progress.rest()
    assert progress.steps == 2
