"""Which priorities and processors the threads of a real `reflexarc run` have, by the kernel."""

import os
from pathlib import Path

import pytest

from support.processes import said_line, started, wait_for_records

LOOP, WATCHDOG, BEHIND = 50, 51, 1


def may_use_fifo() -> bool:
    usual = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(WATCHDOG))
        os.sched_setscheduler(0, *usual)
    except OSError:
        return False
    return True


def standings(process: int) -> dict[int, tuple[int, int, set[int]]]:
    """Of each thread: policy, priority, processors."""
    threads = map(int, os.listdir(f"/proc/{process}/task"))
    return {
        each: (
            os.sched_getscheduler(each),
            os.sched_getparam(each).sched_priority,
            os.sched_getaffinity(each),
        )
        for each in threads
    }


@pytest.mark.skipif(not may_use_fifo(), reason="SCHED_FIFO is not granted here")
def test_every_thread_but_the_loop_s_and_the_watchdog_s_is_behind_and_anywhere(
    policy: Path, port: int, tmp_path: Path
):
    """Among them those that begin last: of senses, swaps, and of the recorder's disk."""
    log, anywhere = tmp_path / "drive.mcap", os.sched_getaffinity(0)
    words = ("run", policy, "--port", port, "--fifo", LOOP, "--cpu", max(anywhere))
    with started(*words, "--record", log) as loop:
        assert f"watchdog {WATCHDOG}; other threads {BEHIND}" in said_line(loop, "watchdog on")
        wait_for_records(log, "tick", 1)  # it ticks, and the syncer has begun
        found = standings(loop.pid)
    own = found.pop(loop.pid)
    assert own == (os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, LOOP, {max(anywhere)})
    watchdog = (os.SCHED_FIFO, WATCHDOG, anywhere)
    assert list(found.values()).count(watchdog) == 1
    others = [each for each in found.values() if each != watchdog]
    assert len(others) > 10  # Zenoh's, the callbacks', the recorder's, the syncer, notices
    assert set(map(str, others)) == {str((os.SCHED_FIFO, BEHIND, anywhere))}
