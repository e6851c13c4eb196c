"""The three roles as plain rclpy nodes. Runs in an environment with rclpy, not in ours.

Variants of the brain: `timer` decides in a timer's callback on the last retina, as a node with a
control rate does; `timer, age checked` has three lines more; `arrival` decides in the callback of
the subscription. All spin in `rclpy.spin`. Retinas have the quality of service of sensors (best
effort), commands are reliable, of depth 1. (The experimental `EventsExecutor` of these wheels calls
no timer and no subscription.)
"""

import time
from array import array

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rclpy.timer import TimerInfo
from roles import Body, Brain, Options, options, send_retinas
from std_msgs.msg import UInt8MultiArray

RELIABLE = QoSProfile(depth=1)
MOST_AGE_NS = 100_000_000


class BrainNode(Node):
    """Decides at a timer, or when a retina comes."""

    def __init__(self, told: Options) -> None:
        super().__init__("brain")
        self._brain = Brain(told.folder, MOST_AGE_NS if "age" in told.variant else 0)
        self._commands = self.create_publisher(UInt8MultiArray, "command", RELIABLE)
        self._at_timer = told.variant.startswith("timer")
        self.create_subscription(UInt8MultiArray, "retina", self._see, qos_profile_sensor_data)
        if self._at_timer:
            self.create_timer(told.period_ns * 1e-9, self._tick)

    def _see(self, message: UInt8MultiArray) -> None:
        self._brain.see(bytes(message.data))
        if not self._at_timer:
            self._act()

    def _tick(self, info: TimerInfo) -> None:
        self._brain.wake(max(0, time.time_ns() - info.expected_call_time.nanoseconds))
        self._act()

    def _act(self) -> None:
        command = self._brain.decide()
        if command is not None:
            self._commands.publish(UInt8MultiArray(data=array("B", command)))


class BodyNode(Node):
    """Notes each command."""

    def __init__(self, told: Options) -> None:
        super().__init__("body")
        self._body = Body(told.folder)
        self.create_subscription(UInt8MultiArray, "command", self._hear, RELIABLE)

    def _hear(self, message: UInt8MultiArray) -> None:
        self._body.hear(bytes(message.data))


def main() -> None:
    """Be the role that the command line names, as a node of rclpy."""
    told = options()
    rclpy.init()
    if told.role == "sensor":
        node = Node("sensor")
        retinas = node.create_publisher(UInt8MultiArray, "retina", qos_profile_sensor_data)
        send_retinas(
            lambda payload: retinas.publish(UInt8MultiArray(data=array("B", payload))),
            told.period_ns,
        )
    node = BrainNode(told) if told.role == "brain" else BodyNode(told)
    rclpy.spin(node)


if __name__ == "__main__":
    main()
