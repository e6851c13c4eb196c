"""Scan → bridge → runtime → twist with a robot that other people's libraries make, both ways.

zenoh-ros2-sdk (Apache-2.0) computes keys, type hashes, tokens, CDR and attachments by itself, and
opens its session as rmw_zenoh does. pamoja-ros2 (MIT) makes keys and CDR in Rust.
"""

import importlib.util
import json
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import decode, read_log
from reflexarc_runtime.ros2.ros_types import LASER_SCAN, TWIST
from support.processes import PATIENCE_S, finished, said_line, started, wait_until
from support.ros2_drives import FAST_ENOUGH
from support.ros2_robot import rmw_robot_session, rmw_router

SCANS = 150
PEER = Path(__file__).parents[1] / "support" / "sdk_peer.py"


def peer_needs(module: str, package: str) -> pytest.MarkDecorator:
    is_there = importlib.util.find_spec(module) is not None
    return pytest.mark.skipif(not is_there, reason=f"{package} is not installed: make check")


@pytest.mark.long
@peer_needs("zenoh_ros2_sdk", "zenoh-ros2-sdk")
def test_a_robot_of_the_sdk_is_driven_by_its_own_scans_and_its_odometry_is_recorded(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    words = ["--wire", "rmw", "--stamped", "--auto-arm", "--json", "--port", port, *FAST_ENOUGH]
    run = ["run", policy, "--input", "scan", "--port", port, "--record", log]
    with rmw_router(port), started(*run) as runtime:
        said_line(runtime, "reflexarc run:")
        with started("ros2", *words) as bridge:
            robot = subprocess.run(
                [sys.executable, PEER, str(port), str(SCANS), "stamped"],
                capture_output=True,
                text=True,
                timeout=PATIENCE_S,
                check=True,
            )
            account = finished(bridge, signal.SIGINT)
        runtime.send_signal(signal.SIGINT)
        runtime.wait(PATIENCE_S)
    heard = json.loads(robot.stdout)
    moved = [(ahead, stamp) for _, ahead, stamp in heard["told"] if ahead]
    assert account["scans"] == SCANS
    assert account["refused_scans"] == account["refused_places"] == {}
    assert len(moved) > SCANS / 2
    # A motion bears the stamp of a scan of this robot, to the resolution of a float of its time.
    offset_s = time.time() - time.monotonic()
    scans_s = [left_s + offset_s for left_s in heard["left_s"]]
    assert all(min(abs(stamp - scan) for scan in scans_s) < 0.01 for _, stamp in moved)
    drive = read_log(log)
    poses = [decode(drive, one, PoseInFrame) for one in drive.records("/robot0/pose")]
    places = [pose.pose.position.x for pose in poses]
    assert len(places) > SCANS / 2
    assert places == sorted(places)
    assert {pose.frame_id for pose in poses} == {"odom"}


@peer_needs("pamoja.ros2", "pamoja-ros2")
def test_a_robot_of_pamoja_is_driven_by_its_own_scans(policy: Path, port: int):
    from pamoja import ros2

    told: list[float] = []
    ended = threading.Event()
    run = ["run", policy, "--input", "scan", "--port", port]
    words = ["--wire", "rmw", "--auto-arm", "--json", "--port", port, *FAST_ENOUGH]
    with rmw_robot_session(port) as session:
        scan_key = ros2.entity_key(0, "/scan", "sensor_msgs/msg/LaserScan", LASER_SCAN.type_hash)
        wheel_key = ros2.entity_key(0, "/cmd_vel", "geometry_msgs/msg/Twist", TWIST.type_hash)
        wheels = session.declare_subscriber(
            wheel_key,
            lambda sample: told.append(ros2.twist_from_cdr(sample.payload.to_bytes())[0][0]),
        )
        scanner = session.declare_publisher(scan_key)

        def scan() -> None:
            while not ended.wait(0.02):
                scanner.put(scan_of_pamoja())

        thread = threading.Thread(target=scan)
        with started(*run), started("ros2", *words) as bridge:
            thread.start()
            try:
                wait_until(lambda: sum(map(bool, told)) > 50, "the robot drives")
            finally:
                ended.set()
                thread.join()
                wheels.undeclare()
            account = finished(bridge, signal.SIGINT)
    assert account["scans"] > 25
    assert account["refused_scans"] == {}


def scan_of_pamoja() -> bytes:
    """An empty room in 181 beams; a writer of numbers alone writes "las" as one of them."""
    from pamoja import ros2

    writer = ros2.CdrWriter()
    seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
    writer.write_i32(seconds)
    writer.write_u32(nanoseconds)
    writer.write_u32(4)
    writer.write_u32(int.from_bytes(b"las\0", "little"))
    for number in (-1.5707964, 1.5707964, 3.1415927 / 180, 0.0, 0.02, 0.1, 10.0):
        writer.write_f32(number)
    writer.write_u32(181)
    for _ in range(181):
        writer.write_f32(float("inf"))
    writer.write_u32(0)
    return bytes(writer.bytes)
