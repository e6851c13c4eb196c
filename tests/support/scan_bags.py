"""Bags of ROS 2 in MCAP, written by rosbags: laser scans, and the twists of a controller."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

STORE = get_typestore(Stores.ROS2_JAZZY)
PERIOD_NS = 100_000_000
START_NS = 1_700_000_000_000_000_000

Twist = Callable[[Any], tuple[float, float]]
"""What a controller makes of a scan: metres a second ahead, radians a second."""


def scans(count: int, beams: int = 30, seed: int = 0) -> list[Any]:
    """Scans of a room that changes slowly; some beams come back from nowhere."""
    rng = np.random.default_rng(seed)
    walls = 1.5 + rng.normal(size=(count, beams)).cumsum(axis=0) * 0.1
    ranges = np.clip(walls, 0.2, 9.0).astype(np.float32)
    ranges[rng.random(ranges.shape) < 0.05] = np.inf
    return [_scan(number, row) for number, row in enumerate(ranges)]


def _scan(number: int, ranges: "np.ndarray[Any, Any]") -> Any:
    types = STORE.types
    at_ns = START_NS + number * PERIOD_NS
    stamp = types["builtin_interfaces/msg/Time"](sec=at_ns // 10**9, nanosec=at_ns % 10**9)
    step = np.pi / len(ranges)
    return types["sensor_msgs/msg/LaserScan"](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id="laser"),
        angle_min=-np.pi / 2,
        angle_max=np.pi / 2,
        angle_increment=step,
        time_increment=0.0,
        scan_time=0.1,
        range_min=0.05,
        range_max=10.0,
        ranges=ranges,
        intensities=np.zeros(0, np.float32),
    )


def twist(linear_mps: float, angular_radps: float) -> Any:
    """A message."""
    vector, kind = STORE.types["geometry_msgs/msg/Vector3"], STORE.types["geometry_msgs/msg/Twist"]
    zero = vector(x=0.0, y=0.0, z=angular_radps)
    return kind(linear=vector(x=linear_mps, y=0.0, z=0.0), angular=zero)


def write_bag(
    folder: Path, seen: Iterable[Any], controller: Twist | None, late_ns: int = 7_000_000
) -> Path:
    """The MCAP file of a bag: each scan, and a while later the twist of a controller, if any."""
    with Writer(folder, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        laser, motion = "sensor_msgs/msg/LaserScan", "geometry_msgs/msg/Twist"
        to_scan = writer.add_connection("/scan", laser, typestore=STORE)
        to_twist = None
        if controller is not None:
            to_twist = writer.add_connection("/cmd_vel", motion, typestore=STORE)
        for number, scan in enumerate(seen):
            at_ns = START_NS + number * PERIOD_NS
            writer.write(to_scan, at_ns, STORE.serialize_cdr(scan, laser))
            if controller is not None and to_twist is not None:
                said = STORE.serialize_cdr(twist(*controller(scan)), motion)
                writer.write(to_twist, at_ns + late_ns, said)
    [path] = folder.glob("*.mcap")
    return path
