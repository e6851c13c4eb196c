"""Lockstep: the same drive, whatever else the machine does."""

import multiprocessing
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from support.processes import finished, started

STEPS = 300


def spin() -> None:
    while True:
        pass


@contextmanager
def load(processes: int) -> Iterator[None]:
    context = multiprocessing.get_context("spawn")
    burners = [context.Process(target=spin, daemon=True) for _ in range(processes)]
    for burner in burners:
        burner.start()
    try:
        yield
    finally:
        for burner in burners:
            burner.kill()
            burner.join()


def drive(policy: Path, port: int, log: Path, *, recorder: bool = False) -> list[bytes]:
    """Decisions of a lockstep drive, as bytes."""
    words = ("run", policy, "--lockstep", "--port", port, "--record", log, "--json")
    with (
        started("record", "-o", log.with_suffix(".heard"), "--port", port) if recorder else load(0),
        started(*words) as runtime,
        started("sim", "--lockstep", "--steps", STEPS, "--port", port, "--json") as body,
    ):
        finished(body)
        finished(runtime, signal.SIGINT)
    return [tick.decision.SerializeToString(deterministic=True) for tick in read_log(log).ticks()]


@pytest.mark.long
def test_the_same_drive_gives_the_same_decisions_on_an_idle_and_on_a_loaded_machine(
    policy: Path, port: int, tmp_path: Path
):
    idle = drive(policy, port, tmp_path / "idle.mcap")
    with load(4):
        loaded = drive(policy, port, tmp_path / "loaded.mcap", recorder=True)
    assert len(idle) == STEPS + 1
    assert idle == loaded
    assert replay(tmp_path / "loaded.mcap").exit_status == 0
