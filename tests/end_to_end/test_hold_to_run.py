"""A button that a person holds, in real processes: killed, stopped, continued, let go."""

import os
import pty
import signal
import subprocess
import sys
import time
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import HOLD_TO_RUN
from reflexarc_runtime.messages.wire import unpack_stamp
from support.processes import Process, finished, reflexarc, said_line, started, wait_until
from support.ros2_drives import FAST_ENOUGH, bridged, stands
from support.ros2_robot import robot
from support.witness import Witness, body, runtime, tell, witness


def held(port: int) -> AbstractContextManager[Process]:
    return started("arm", "--hold", "--port", port, "--json")


def until_it_rolls(seen: Witness) -> None:
    wait_until(lambda: seen.rolled_m(0.2) > 0.05, "a drive", 30.0)


def until_it_stands(seen: Witness) -> None:
    seen.wait_for(lambda lease: not lease.armed, "a body that is not armed")
    assert seen.rolled_m() == 0.0


def ended_in_vain(process: Process) -> str:
    _, complaint = process.communicate(timeout=30.0)
    assert process.returncode == 1
    return complaint


def test_a_body_drives_while_the_button_is_held_and_no_longer(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    with (
        body(policy, port, tmp_path, "--hold-to-run"),
        witness(port) as seen,
        runtime(policy, port, tmp_path, "--record", log) as loop,
    ):
        seen.wait_for(lambda lease: bool(lease.holder and lease.refused), "a runtime that waits")
        status, said = tell(port, "arm", "--patience", 1)
        assert (status, said["state"]) == (1, "waiting for a held button")
        assert seen.rolled_m() == 0.0
        with held(port) as button:
            until_it_rolls(seen)
            said = finished(button, signal.SIGINT)
        assert (said["done"], said["armed"], said["held_by"]) == (True, False, "")
        until_it_stands(seen)
        finished(loop, signal.SIGINT)
    holds = [
        pb.HoldToRun.FromString(r.payload) for r in read_log(log).records("/robot0/hold_to_run")
    ]
    assert [hold.held for hold in holds][-1] is False
    assert len({hold.pressed_time_ns for hold in holds}) == 1
    assert replay(log).exit_status == 0


def test_the_kill_of_whoever_holds_the_button_stops_the_body(
    policy: Path, port: int, tmp_path: Path
):
    with (
        body(policy, port, tmp_path, "--hold-to-run"),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
    ):
        with held(port) as button:
            until_it_rolls(seen)
            button.kill()
        until_it_stands(seen)
        with held(port):
            until_it_rolls(seen)  # another press


@pytest.mark.long
def test_whoever_was_stopped_with_the_button_down_does_not_drive_on_when_continued(
    policy: Path, port: int, tmp_path: Path
):
    with (
        body(policy, port, tmp_path, "--hold-to-run"),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
        held(port) as button,
    ):
        until_it_rolls(seen)
        button.send_signal(signal.SIGSTOP)
        until_it_stands(seen)
        begin_m = seen.x_m[-1]
        button.send_signal(signal.SIGCONT)
        assert "no longer felt the button" in ended_in_vain(button)
        assert seen.x_m[-1] == begin_m


@pytest.mark.long
def test_what_was_recorded_of_a_button_arms_nothing(policy: Path, port: int, tmp_path: Path):
    with (
        body(policy, port, tmp_path, "--hold-to-run"),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
    ):
        recorded = []
        seen.bus.subscribe([HOLD_TO_RUN], recorded.append)
        with held(port) as button:
            until_it_rolls(seen)
            finished(button, signal.SIGTERM)
        until_it_stands(seen)
        publisher = seen.publisher(HOLD_TO_RUN)
        for message in recorded[:-1]:  # at once, in a burst, under its own name
            assert unpack_stamp(message.attachment).sender != seen.bus.sender
            publisher.put_raw(message.payload, message.attachment, message.encoding)
        assert seen.rolled_m() == 0.0
        assert not seen.lease.armed


@pytest.mark.long
def test_a_stop_beats_a_held_button_and_a_reset_does_not_bring_it_back(
    policy: Path, port: int, tmp_path: Path
):
    with (
        body(policy, port, tmp_path, "--hold-to-run"),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
        held(port) as button,
    ):
        until_it_rolls(seen)
        assert tell(port, "stop")[0] == 0
        assert seen.rolled_m() == 0.0
        assert "no longer felt the button" in ended_in_vain(button)
        assert tell(port, "reset")[0] == 0
        assert seen.rolled_m() == 0.0


@pytest.mark.long
def test_at_a_terminal_any_key_lets_go(policy: Path, port: int, tmp_path: Path):
    with body(policy, port, tmp_path, "--hold-to-run"), witness(port) as seen:
        master, terminal = pty.openpty()
        words = [sys.executable, "-m", "reflexarc", "arm", "--hold", "--port", str(port)]
        button = subprocess.Popen(
            ["setsid", "--ctty", "--wait", *words],
            stdin=terminal,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        said_line(button, "may drive until a key")
        assert seen.lease.armed
        time.sleep(0.2)
        os.write(master, b"x")
        said, _ = button.communicate(timeout=30.0)
        assert button.returncode == 0
        assert said.startswith("robot0: not armed")
        os.close(terminal)
        os.close(master)


def test_a_button_that_nobody_feels_ends_with_1_and_one_line(port: int):
    done = reflexarc("arm", "--hold", "--port", port, "--patience", 0.5)
    assert done.returncode == 1
    assert done.stderr == "reflexarc arm: no body of robot0 answered within 0.5 s\n"


@pytest.mark.long
def test_a_robot_that_speaks_ros_drives_while_the_button_is_held(policy: Path, port: int):
    with (
        robot(port, "scan", "cmd_vel", stamped=False) as base,
        started("run", policy, "--input", "scan", "--no-guard", "--port", port),
        started("arm", "--hold", "--patience", 200, "--port", port) as button,
        bridged(base, port, *FAST_ENOUGH, "--hold-to-run"),  # it waits until the robot drives
    ):
        button.kill()
        wait_until(lambda: stands(base.told), "the robot stands", 30.0)
        told = len(base.told)
        wait_until(lambda: len(base.told) > told + 25, "half a second more", 30.0)
        assert all(word.is_standstill for word in base.told[told:])
