"""The rule by which diff_drive_controller obeys stamped twists, by its own clock.

ros-controls/ros2_controllers, `diff_drive_controller/src/diff_drive_controller.cpp` (commit
94e74de, 2026): the subscription's callback in `on_configure` takes a stamp of zero for now and
ignores a message that is not younger than `cmd_vel_timeout`; `update_reference_from_subscribers`
brakes when the last one has become older than that. A stamp of a time to come is never too old.
"""

from dataclasses import dataclass

from support.ros2 import TwistStamped

TIMEOUT_NS = 500_000_000
"""`cmd_vel_timeout` by default."""


@dataclass
class DiffDrive:
    """What the wheels are told."""

    timeout_ns: int = TIMEOUT_NS
    stamp_ns: int = 0
    ahead_mps: float = 0.0
    ignored: int = 0

    def hear(self, payload: bytes, now_ns: int) -> None:
        """Take a `TwistStamped`."""
        message = TwistStamped.deserialize(payload)
        stamp = message.header.stamp
        stamp_ns = stamp.sec * 1_000_000_000 + stamp.nanosec or now_ns
        if now_ns - stamp_ns < self.timeout_ns:
            self.stamp_ns, self.ahead_mps = stamp_ns, message.twist.linear.x
        else:
            self.ignored += 1

    def speed_mps(self, now_ns: int) -> float:
        """The speed that is wanted of the wheels now."""
        return 0.0 if now_ns - self.stamp_ns > self.timeout_ns else self.ahead_mps
