"""A robot's node by zenoh-ros2-sdk: scans out, twists in, in a process of its own.

    python tests/support/sdk_peer.py PORT SCANS [stamped]

It computes keys, type hashes, tokens and CDR itself. It sends scans, one every 20 ms, as long as
nobody has told it anything; then so many, numbered; and prints as JSON when each one left, and what
it was told and when, in seconds of the monotonic clock. It says where it is as well.
"""

import json
import random
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber
from zenoh_ros2_sdk.session import ZenohSession
from zenoh_ros2_sdk.utils import get_type_hash

from support.ros2_definitions import DEFINITIONS

PERIOD_S = 0.02
BEAMS = 181


class SdkNode:
    """Publishers and a subscriber of the SDK; what it was told."""

    def __init__(self, port: int, stamped: bool) -> None:
        self.told: list[tuple[float, float, float]] = []
        self._where: dict[str, Any] = {"router_port": port, "domain_id": 0}
        session = ZenohSession.get_instance(router_port=port)
        for name, definition in DEFINITIONS.items():
            session.register_message_type(definition, name)
        self._types = session.store.types
        self._scans = self._publisher("/scan", "sensor_msgs/msg/LaserScan")
        self._odometry = self._publisher("/odom", "nav_msgs/msg/Odometry")
        kind = "geometry_msgs/msg/TwistStamped" if stamped else "geometry_msgs/msg/Twist"
        hear = self._hear_stamped if stamped else self._hear
        self._wheels = ROS2Subscriber("/cmd_vel", kind, hear, **self._definition(kind))

    def scan(self) -> float:
        """Send a scan of an empty room and the odometry; the moment before."""
        now_s = time.monotonic()
        empty = np.full(BEAMS, np.inf, np.float32)
        step = np.float32(np.pi / (BEAMS - 1))
        self._scans.publish(
            header=self._header("laser"),
            angle_min=-np.pi / 2,
            angle_max=np.pi / 2,
            angle_increment=step,
            time_increment=0.0,
            scan_time=PERIOD_S,
            range_min=0.1,
            range_max=10.0,
            ranges=empty,
            intensities=np.empty(0, np.float32),
        )
        return now_s

    def place(self, x_m: float) -> None:
        """Say where it is."""
        self._odometry.publish(
            header=self._header("odom"),
            child_frame_id="base_link",
            pose=self._covered("Pose", position=self._point("Point", x_m)),
            twist=self._covered("Twist"),
        )

    def _header(self, frame: str) -> Any:
        seconds, nanoseconds = divmod(time.time_ns(), 1_000_000_000)
        stamp = self._types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
        return self._types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)

    def _point(self, kind: str, x: float = 0.0) -> Any:
        return self._types[f"geometry_msgs/msg/{kind}"](x=x, y=0.0, z=0.0)

    def _covered(self, kind: str, position: Any = None) -> Any:
        make = {name.rpartition("/")[2]: self._types[name] for name in DEFINITIONS}
        if kind == "Pose":
            turn = make["Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0)
            inner = make["Pose"](position=position, orientation=turn)
        else:
            inner = make["Twist"](linear=self._point("Vector3"), angular=self._point("Vector3"))
        return make[f"{kind}WithCovariance"](**{kind.lower(): inner}, covariance=np.zeros(36))

    def _publisher(self, topic: str, kind: str) -> ROS2Publisher:
        return ROS2Publisher(topic, kind, **self._definition(kind))

    def _definition(self, kind: str) -> dict[str, Any]:
        others = {name: text for name, text in DEFINITIONS.items() if name != kind}
        hashed = get_type_hash(kind, msg_definition=DEFINITIONS[kind], dependencies=others)
        return {"msg_definition": DEFINITIONS[kind], "type_hash": hashed, **self._where}

    def _hear(self, twist: Any) -> None:
        self.told.append((time.monotonic(), twist.linear.x, 0.0))

    def _hear_stamped(self, message: Any) -> None:
        stamp = message.header.stamp
        heard = (time.monotonic(), message.twist.linear.x, stamp.sec + stamp.nanosec * 1e-9)
        self.told.append(heard)


def main() -> None:
    """Wait for a bridge, send, print."""
    port, scans, stamped = int(sys.argv[1]), int(sys.argv[2]), "stamped" in sys.argv
    node, jitter = SdkNode(port, stamped), random.Random(7)
    print("ready", file=sys.stderr, flush=True)
    while not node.told:
        time.sleep(PERIOD_S)
    left_s = []
    for number in range(scans):
        left_s.append(node.scan())
        node.place(0.01 * number)
        time.sleep(jitter.uniform(0.75, 1.25) * PERIOD_S)
    time.sleep(0.5)
    print(json.dumps({"left_s": left_s, "told": node.told}))
    ZenohSession.get_instance(router_port=port).close()


if __name__ == "__main__":
    main()
