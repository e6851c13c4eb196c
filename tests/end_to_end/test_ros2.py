"""A robot that speaks ROS 2 ↔ `reflexarc ros2` ↔ `reflexarc run --input scan`."""

import signal
import struct
import time
from pathlib import Path

import pytest
import zenoh.ext

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.ros2.ros_types import TF_MESSAGE
from reflexarc_sim_bridge.body.ros2.wires import RmwWire
from support.processes import finished, said_line, started, wait_until
from support.ros2 import TFMessage, transform
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
    assert account["twists"] == sum(word.sender == driven[0].sender for word in body.told)
    assert account["twists"] - account["standstills"] == len(driven)


@pytest.mark.parametrize("distribution", ["jazzy", "humble"])
def test_a_scanner_that_falls_silent_leaves_the_robot_standing_on_rmw(
    policy: Path, port: int, distribution: str
):
    scan_key, command_key = f"7/scan/{LASER_SCAN}", f"7/cmd_vel/{TWIST}"
    if distribution == "humble":
        scan_key, command_key = map(without_hash, (scan_key, command_key))
    with robot(port, scan_key, command_key, stamped=False, rmw=True) as body:
        words = ["--wire", "rmw", "--domain", "7", "--json", "--port", port, "--node", "b/eye"]
        words += ["--distribution", distribution]
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
    assert kinds == ["MP", "MS", "MS", "MS", "MS", "NN"]  # scan, odom, tf and tf_static are heard
    assert all(token.split("/")[7:9] == ["%b", "eye"] for token in tokens)
    said = command_key.removeprefix("7/cmd_vel/")
    assert any(token.endswith(f"/eye/%cmd_vel/{said}/::,10:,:,:,,") for token in tokens)
    check_attachments(body.told)


def test_on_rmw_the_bridge_waits_for_a_router_that_starts_later(port: int):
    words = ["--wire", "rmw", "--json", "--port", port, *FAST_ENOUGH]
    with started("ros2", *words) as bridge:
        assert f":{port}: waiting" in said_line(bridge, "no Zenoh router")
        with robot(
            port, f"0/scan/{LASER_SCAN}", f"0/cmd_vel/{TWIST}", stamped=False, rmw=True
        ) as it:
            wait_until(lambda: len(it.told) > 50, "the bridge speaks")
            account = finished(bridge, signal.SIGINT)
    assert account["scans"] > 0


def test_a_bridge_that_waits_for_its_router_ends_when_asked(port: int):
    with started("ros2", "--wire", "rmw", "--port", port, *FAST_ENOUGH) as bridge:
        said_line(bridge, "no Zenoh router")
        bridge.send_signal(signal.SIGINT)
        assert bridge.wait(30.0) == 0


def test_a_peer_on_rmw_is_told_that_it_may_hear_nothing(port: int, tmp_path: Path):
    file = tmp_path / "peer.json5"
    file.write_text(
        f'{{ mode: "peer", scouting: {{ multicast: {{ enabled: false }} }}, '
        f'connect: {{ endpoints: ["tcp/127.0.0.1:{port}"] }}, listen: {{ endpoints: [] }} }}'
    )
    with (
        robot(port, f"0/scan/{LASER_SCAN}", f"0/cmd_vel/{TWIST}", stamped=False, rmw=True),
        started("ros2", "--wire", "rmw", "--zenoh", file, *FAST_ENOUGH) as bridge,
    ):
        assert "mode" in said_line(bridge, 'expected mode "client"')
        bridge.send_signal(signal.SIGINT)
        assert bridge.wait(30.0) == 0


def test_a_static_transform_that_was_said_before_the_bridge_began_is_on_our_bus(port: int):
    # rmw_zenoh's transient local publishers are zenoh-ext's, with a cache that answers queries.
    scan_key, command_key = f"0/scan/{LASER_SCAN}", f"0/cmd_vel/{TWIST}"
    static_key = RmwWire().key("/tf_static", TF_MESSAGE)
    words = ["--wire", "rmw", "--json", "--port", port, *FAST_ENOUGH]
    with robot(port, scan_key, command_key, stamped=False, rmw=True) as body:
        latched = zenoh.ext.declare_advanced_publisher(
            body.session,
            static_key,
            cache=zenoh.ext.CacheConfig(max_samples=1),
            publisher_detection=True,
        )
        latched.put(TFMessage([transform("laser", 0.25)]).serialize())
        with started("ros2", *words) as bridge:
            wait_until(lambda: len(body.told) > 20, "the bridge speaks")
            account = finished(bridge, signal.SIGINT)
        latched.undeclare()
    assert account["transforms"] > 0
    assert account["refused_places"] == {}


def test_two_bridges_on_one_robot_have_names_keys_and_topics_of_their_own(port: int):
    scan_key = f"0/scan/{LASER_SCAN}"
    both = ["--wire", "rmw", "--json", "--port", port, *FAST_ENOUGH]
    left = [*both, "--node", "left", "--robot", "left", "--command", "left_vel"]
    right = [*both, "--node", "right", "--robot", "right", "--command", "right_vel"]
    with (
        robot(port, scan_key, f"0/*/{TWIST}", stamped=False, rmw=True) as body,
        started("ros2", *left) as one,
        started("ros2", *right) as other,
    ):
        wait_until(lambda: len({word.sender for word in body.told}) == 2, "both speak")
        tokens = body.tokens()
        accounts = [finished(bridge, signal.SIGINT) for bridge in (one, other)]
    assert all(account["scans"] > 0 for account in accounts)
    nodes = {token.split("/")[8]: token.split("/")[2] for token in tokens}
    assert nodes.keys() == {"left", "right"}
    assert len(set(nodes.values())) == 2  # a Zenoh session each


def without_hash(key: str) -> str:
    return key.rpartition("/")[0] + "/TypeHashNotSupported"


def check_attachments(told: list[Told]) -> None:
    """33 bytes each: numbers without a gap for each sender, the wall clock."""
    read = [struct.unpack("<qqB16s", word.attachment) for word in told]
    assert {length for _, _, length, _ in read} == {16}
    assert all(abs(told_ns.arrived_ns - r[1]) < 60e9 for told_ns, r in zip(told, read, strict=True))
    for sender in {word.sender for word in told}:
        numbers = [number for number, _, _, one in read if one == sender]
        assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
