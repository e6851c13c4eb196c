"""A robot that speaks ROS 2 ↔ `reflexarc ros2` ↔ `reflexarc run --input scan`."""

import signal
import struct
import time
from pathlib import Path

from reflexarc_runtime.contract.contract import PolicyContract
from support.processes import finished, said_line, started, wait_until
from support.ros2_drives import FAST_ENOUGH
from support.ros2_robot import Told, robot

LASER_SCAN = "sensor_msgs::msg::dds_::LaserScan_/RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"  # noqa: E501
TWIST = "geometry_msgs::msg::dds_::Twist_/RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"  # noqa: E501

VALID_FOR_NS = PolicyContract().max_input_age_ns
PERIOD_NS = 20_000_000


def is_driving(told: list[Told], count: int = 25) -> bool:
    return len(told) >= count and not any(word.is_standstill for word in told[-count:])


def test_a_runtime_that_is_killed_leaves_the_robot_standing(policy: Path, port: int):
    with robot(port, "bot1/scan", "bot1/cmd_vel", stamped=True) as body:
        words = ["--topic", "bot1/scan", "--command", "/bot1/cmd_vel", "--stamped", "--json"]
        with started("ros2", *words, *FAST_ENOUGH, "--auto-arm", "--port", port) as bridge:
            with started("run", policy, "--input", "scan", "--port", port) as runtime:
                said_line(runtime, "reflexarc run:")
                wait_until(lambda: is_driving(body.told), "the robot drives")
                runtime.kill()
                runtime.wait()
                killed_ns = time.time_ns()
            wait_until(lambda: sum(w.is_standstill for w in body.told[-50:]) == 50, "it stands")
            account = finished(bridge, signal.SIGINT)
    driven = [word for word in body.told if not word.is_standstill]
    stood = [word for word in body.told if word.is_standstill]
    # The robot's clock is the wall clock here: a motion is as old as its scan, a standstill never.
    assert driven[-1].stamp_ns < killed_ns
    assert all(word.stamp_ns == 0 for word in stood)
    assert all(0 < word.arrived_ns - word.stamp_ns < VALID_FOR_NS + PERIOD_NS for word in driven)
    assert account["refused_scans"] == {}
    assert account["commands"] > 0
    assert account["twists"] == len(body.told)
    assert account["twists"] - account["standstills"] == len(driven)


def test_a_scanner_that_falls_silent_leaves_the_robot_standing_on_rmw(policy: Path, port: int):
    scan_key, command_key = f"7/scan/{LASER_SCAN}", f"7/cmd_vel/{TWIST}"
    with robot(port, scan_key, command_key, stamped=False) as body:
        words = ["--wire", "rmw", "--domain", "7", "--json", "--port", port]
        with started("ros2", *words, *FAST_ENOUGH, "--auto-arm") as bridge:
            with started("run", policy, "--input", "scan", "--port", port) as runtime:
                wait_until(lambda: is_driving(body.told), "the robot drives")
                tokens = body.tokens()
                body.scanning.clear()
                wait_until(lambda: sum(w.is_standstill for w in body.told[-50:]) == 50, "it stands")
                runtime.send_signal(signal.SIGINT)
            finished(bridge, signal.SIGINT)
        wait_until(lambda: not body.tokens(), "its tokens are gone")
    kinds = sorted(token.split("/")[5] for token in tokens)
    assert kinds == ["MP", "MS", "NN"]
    assert any(token.endswith(f"/reflexarc/%cmd_vel/{TWIST}/::,10:,:,:,,") for token in tokens)
    check_attachments(body.told)


def check_attachments(told: list[Told]) -> None:
    """33 bytes each: numbers without a gap, the wall clock, one sender."""
    read = [struct.unpack("<qqB16s", word.attachment) for word in told]
    assert [number for number, *_ in read] == list(range(read[0][0], read[0][0] + len(read)))
    assert all(abs(told_ns.arrived_ns - r[1]) < 60e9 for told_ns, r in zip(told, read, strict=True))
    assert len({sender for *_, sender in read}) == 1
    assert {length for _, _, length, _ in read} == {16}
