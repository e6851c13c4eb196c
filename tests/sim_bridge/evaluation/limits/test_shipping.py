"""The oracle's figures that ship are computed by processes that do not outlive their parent."""

import os
import signal
import subprocess
import sys
import time

import pytest

from reflexarc_runtime.crew.worker_process import Task
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.limits.kept import shipped_figures
from reflexarc_sim_bridge.evaluation.limits.shipping import computed, units_to_ship

_PARENT = """
from reflexarc_runtime.crew import crew as module
from reflexarc_runtime.crew.worker_process import Task, WorkerProcess
from reflexarc_sim_bridge.evaluation.limits.shipping import computed

class Telling(WorkerProcess):
    def give(self, task):
        super().give(task)
        print(self._process.pid, flush=True)

module.WorkerProcess = Telling
next(computed([Task("0", {"unit": 0})], 1))
"""
"""Says which process has been given the dearest unit, which takes it a minute and more."""


@pytest.mark.long
def test_a_worker_finds_what_ships() -> None:
    cheap = [n for n, unit in enumerate(units_to_ship()) if unit[0].tier == "slippery"][-1:]
    ((key, figures),) = computed([Task(str(n), {"unit": n}) for n in cheap], 1)
    assert figures == pytest.approx(shipped_figures()[key], rel=1e-12, abs=1e-12)


def test_a_unit_that_cannot_be_computed_ends_the_work() -> None:
    with pytest.raises(UsageError, match=r"unit 9: 2 processes died doing it"):
        list(computed([Task("9", {"unit": -10_000})], 1))


def test_workers_end_with_a_parent_that_is_killed() -> None:
    parent = subprocess.Popen([sys.executable, "-c", _PARENT], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    with parent.stdout:
        worker = int(parent.stdout.readline())
        parent.send_signal(signal.SIGKILL)
        parent.wait()
    _wait_until_gone(worker)


def _wait_until_gone(pid: int) -> None:
    deadline_s = time.monotonic() + 10.0
    while time.monotonic() < deadline_s:
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            return
        if _is_zombie(pid):
            return
        time.sleep(0.05)
    pytest.fail(f"process {pid} outlives its parent")


def _is_zombie(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True
