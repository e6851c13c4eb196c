"""Whatever ends `reflexarc ros2`, or whoever speaks to it, the robot stands or is slow enough."""

import json
import math
import os
import signal
import time
from pathlib import Path

import pytest

from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Input, drive_command
from reflexarc_runtime.messages import codec
from reflexarc_runtime.messages.topics import COMMAND, STATUS
from reflexarc_runtime.messages_pb2 import Status
from support.processes import PATIENCE_S, finished, reflexarc, said_line, started, wait_until
from support.ros2_base import HOLDS_FOR_EVER, WITH_TIMEOUT, rolled
from support.ros2_drives import (
    FAST_ENOUGH,
    Drive,
    driving,
    kill_group,
    lives,
    moves,
    silence_s,
    stands,
)
from support.ros2_robot import robot

QUIET_S = 1.0
"""So long without a twist: nobody speaks any more."""


def stands_for_good(drive: Drive, since_ns: int) -> bool:
    """Whether both bases stood at the end, once all were silent."""
    wait_until(lambda: silence_s(drive.body.told) > QUIET_S, "all are silent")
    told, until_ns = drive.body.told, time.time_ns()
    rolls = [rolled(base, told, since_ns, until_ns) for base in (HOLDS_FOR_EVER, WITH_TIMEOUT)]
    return all(roll.standstill_s < math.inf and roll.distance_m < 2.0 for roll in rolls)


def test_a_bridge_whose_group_is_killed_leaves_a_robot_that_stands(policy: Path, port: int):
    with driving(policy, port) as drive:
        companion = drive.companion
        killed_ns = kill_group(drive.bridge, signal.SIGKILL)
        drive.bridge.wait()
        assert stands_for_good(drive, killed_ns)
        wait_until(lambda: not lives(companion), "the companion has ended")


def test_without_its_companion_a_robot_that_holds_its_last_twist_drives_on(policy: Path, port: int):
    with driving(policy, port, *FAST_ENOUGH, "--auto-arm", "--no-companion") as drive:
        killed_ns = kill_group(drive.bridge, signal.SIGKILL)
        wait_until(lambda: silence_s(drive.body.told) > QUIET_S, "all are silent")
        told, until_ns = drive.body.told, time.time_ns()
        assert rolled(HOLDS_FOR_EVER, told, killed_ns, until_ns).standstill_s == math.inf
        assert rolled(WITH_TIMEOUT, told, killed_ns, until_ns).standstill_s < math.inf


def test_a_bridge_that_is_stopped_is_spoken_for_and_may_go_on(policy: Path, port: int):
    with driving(policy, port) as drive:
        stopped_ns = kill_group(drive.bridge, signal.SIGSTOP)
        assert stands_for_good(drive, stopped_ns)
        assert lives(drive.companion)
        drive.bridge.send_signal(signal.SIGCONT)
        wait_until(lambda: moves(drive.body.told), "the robot drives again")
        finished(drive.bridge, signal.SIGINT)
    assert stands(drive.body.told[-10:] * 3)


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM, signal.SIGINT, signal.SIGQUIT])
def test_a_bridge_that_is_asked_to_end_says_standstill_ten_times(
    policy: Path, port: int, number: signal.Signals
):
    with driving(policy, port) as drive:
        companion = drive.companion
        report = finished(drive.bridge, number)
        assert not lives(companion)
        time.sleep(QUIET_S / 2)
        told = drive.body.told
    assert all(word.is_standstill for word in told[-10:])
    assert report["twists"] == len(told)


def test_a_bridge_without_its_companion_goes_on_and_says_so(policy: Path, port: int):
    heard: list[Status] = []
    with driving(policy, port) as drive, Bus(BusConfig(port=port), time.monotonic_ns) as bus:
        bus.subscribe([STATUS], lambda message: heard.append(Status.FromString(message.payload)))
        os.kill(drive.companion, signal.SIGKILL)
        wait_until(
            lambda: any(status.verdicts["nobody watches the twists"] for status in heard),
            "the status says it",
        )
        wait_until(lambda: moves(drive.body.told), "the robot drives")
        drive.bridge.send_signal(signal.SIGINT)
        said, complaints = drive.bridge.communicate(timeout=PATIENCE_S)
    assert complaints.count("companion has ended") == 1
    assert json.loads(said.splitlines()[-1])["standstills"] >= 10


def test_no_twist_is_faster_than_the_robot_s_own_limits(policy: Path, port: int):
    slow = ("--max-linear", 0.2, "--max-lateral", 0.2, "--max-angular", 0.2, "--auto-arm")
    with driving(policy, port, *slow) as drive:
        report = finished(drive.bridge, signal.SIGINT)
        assert max(word.ahead_mps for word in drive.body.told) == pytest.approx(0.2)
    assert report["refused_commands"]["too fast: slowed down"] > 0


def test_a_stranger_moves_nothing_and_nobody_does_before_the_arm(port: int):
    anonymous = drive_command(0, 0, Action("go", 100.0, 0.0), Input(0, 0, 0, 0), 2**63 - 1)
    with (
        robot(port, "scan", "cmd_vel", stamped=False) as body,
        started("ros2", "--json", "--port", port, *FAST_ENOUGH) as bridge,
    ):
        wait_until(lambda: stands(body.told), "the bridge speaks")
        with Bus(BusConfig(port=port), time.monotonic_ns) as bus:
            publisher = bus.publisher(COMMAND)
            wait_until(lambda: publisher.has_listener, "the bridge listens")
            for attachment in (b"", bytes(33)):
                publisher.put_raw(
                    codec.encode_command(anonymous), attachment, "application/protobuf"
                )
            publisher.put(codec.encode_command(anonymous), time.monotonic_ns())
            begun = len(body.told)
            wait_until(lambda: len(body.told) > begun + 50, "it was heard")
        report = finished(bridge, signal.SIGINT)
    assert all(word.is_standstill for word in body.told)
    assert sum(report["refused_commands"].values()) == 3


def test_an_arm_lets_it_drive_and_a_stop_holds_over_a_new_start(
    policy: Path, port: int, tmp_path: Path
):
    words = ("ros2", "--json", "--port", port, *FAST_ENOUGH)
    with (
        robot(port, "scan", "cmd_vel", stamped=False) as body,
        started("run", policy, "--input", "scan", "--port", port),
    ):
        with started(*words, cwd=tmp_path) as bridge:
            wait_until(lambda: stands(body.told), "it waits for an arm")
            assert reflexarc("arm", "--port", port).returncode == 0
            wait_until(lambda: moves(body.told), "it drives")
            assert reflexarc("stop", "--port", port).returncode == 0
            wait_until(lambda: stands(body.told), "it stands")
            finished(bridge, signal.SIGINT)
        begun = len(body.told)
        with started(*words, "--auto-arm", cwd=tmp_path) as bridge:
            said_line(bridge, "stopped")
            wait_until(lambda: len(body.told) > begun + 50, "it speaks")
            assert all(word.is_standstill for word in body.told[begun:])
            finished(bridge, signal.SIGINT)
