"""A driver that leaves the standard, beside `reflexarc ros2` and `reflexarc run`: with its flag,
and without.
"""

import json
import math
import re
import signal
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import zenoh

from support.processes import PATIENCE_S, Process, started
from support.ros2 import laser_scan
from support.ros2_drives import FAST_ENOUGH
from support.ros2_robot import router

PERIOD_S = 1 / 30
ENOUGH_S = 3.0
"""Of scans that reach the runtime; a reason that is said for ever is said often in it."""


def scan_of(nothing_m: float, limits_m: tuple[float, float]) -> bytes:
    """A thing 1 m away, 45° to the left, and else nothing."""
    ranges_m = [1.0 if 30 <= beam - 180 <= 60 else nothing_m for beam in range(360)]
    step_rad = math.pi / 180
    scan = laser_scan(ranges_m, start_rad=-math.pi, step_rad=step_rad, limits_m=limits_m)
    return bytes(scan.serialize())


@contextmanager
def scanning(session: zenoh.Session, payload: bytes) -> Iterator[None]:
    """Puts a scan on the robot's key 30 times a second."""
    ended = threading.Event()

    def scan() -> None:
        while not ended.wait(PERIOD_S):
            session.put("scan", payload)

    thread = threading.Thread(target=scan)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def driven(port: int, policy: Path, payload: bytes, folder: Path, *flags: object) -> dict[str, Any]:
    """What bridge and runtime say and count of so many seconds of scans."""
    bridge_words = ("ros2", "--port", port, "--json", *FAST_ENOUGH, "--auto-arm", *flags)
    run_words = ("run", policy, "--input", "scan", "--port", port, "--json", "--no-guard")
    with (
        router(port) as session,
        scanning(session, payload),
        started(*bridge_words, cwd=folder) as bridge,
        started(*run_words, "--ticks", round(ENOUGH_S * 30 + 60)) as runtime,
    ):
        run_out, run_said = runtime.communicate(timeout=PATIENCE_S)
        bridge_out, bridge_said = ended(bridge)
    assert runtime.returncode == 0, run_said
    return {
        "verdicts": last_json(run_out)["verdicts"],
        "run": run_said,
        "ros2": bridge_said,
        "refused": last_json(bridge_out)["refused_scans"],
    }


def ended(process: Process) -> tuple[str, str]:
    process.send_signal(signal.SIGINT)
    return process.communicate(timeout=PATIENCE_S)


def last_json(text: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(text.splitlines()[-1])
    return found


def times(words: str, text: str) -> int:
    """How often a terminal shows some words, however its lines are folded."""
    return len(re.findall(words, " ".join(text.split())))


@pytest.mark.long
def test_zeros_are_unknown_until_a_flag_says_that_nothing_was_met(
    port: int, policy: Path, tmp_path: Path
):
    payload = scan_of(0.0, (0.1, 12.0))
    without = driven(port, policy, payload, tmp_path)
    assert "OK" not in without["verdicts"]
    assert without["verdicts"]["INVALID_INPUT"] > 30
    assert times("INVALID_INPUT: scan: .*?--no-return zero", without["run"]) == 1
    assert without["refused"] == {}
    with_flag = driven(port, policy, payload, tmp_path, "--no-return", "zero")
    assert Counter(with_flag["verdicts"]).most_common(1)[0][0] == "OK"
    assert "INVALID_INPUT" not in with_flag["verdicts"]


@pytest.mark.long
def test_a_largest_range_of_zero_is_refused_until_a_flag_says_what_it_is(
    port: int, policy: Path, tmp_path: Path
):
    payload = scan_of(math.inf, (0.1, 0.0))
    without = driven(port, policy, payload, tmp_path)
    assert "OK" not in without["verdicts"]
    assert times("a scan of the robot is refused: .*?--range-max METRES", without["ros2"]) == 1
    assert sum(without["refused"].values()) > 30
    with_flag = driven(port, policy, payload, tmp_path, "--range-max", 12)
    assert Counter(with_flag["verdicts"]).most_common(1)[0][0] == "OK"
    assert with_flag["refused"] == {}


@pytest.mark.long
def test_the_runtime_s_own_flag_serves_as_well(port: int, policy: Path, tmp_path: Path):
    payload = scan_of(0.0, (0.1, 12.0))
    words = ("run", policy, "--input", "scan", "--port", port, "--json", "--no-guard")
    with (
        router(port) as session,
        scanning(session, payload),
        started("ros2", "--port", port, *FAST_ENOUGH, "--auto-arm", cwd=tmp_path),
        started(*words, "--no-return", "zero", "--ticks", 150) as runtime,
    ):
        said, complaint = runtime.communicate(timeout=PATIENCE_S)
    assert runtime.returncode == 0, complaint
    assert Counter(last_json(said)["verdicts"]).most_common(1)[0][0] == "OK"
