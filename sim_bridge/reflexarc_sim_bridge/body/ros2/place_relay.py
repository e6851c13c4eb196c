"""A robot's odometry and transforms, passed on to our bus, so that a recording has them.

They come as often as the robot likes, and many of them at once: what is read and what is passed on
is limited here, by the clock of arrivals, so that they never hold up scans and commands. Static
transforms are said once in a robot's life; they are said again every second, for a recording that
begins later.
"""

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform

from reflexarc_runtime.loop.throttle import SECOND_NS, Throttle
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.frames import decode_odometry, decode_transforms
from reflexarc_runtime.ros2.mounts import Mounts
from reflexarc_sim_bridge.body.ros2.refusals import Refusals

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher

POSE_PERIOD_NS = SECOND_NS // 100
"""Twice as often as most robots say it: at their own rate, half of them would come too early."""
TRANSFORM_PERIOD_NS = SECOND_NS // 20
"""Between two transforms of one frame."""
MAX_FRAMES = 64
"""How many frames are followed; a robot with more of them shows the first."""
READ_A_SECOND = 200
"""How many messages of transforms are read: every node may send one for each of its frames."""
TOO_MANY = f"more than {MAX_FRAMES} frames"
TOO_OFTEN = f"more than {READ_A_SECOND} messages a second"


class PoseRelay:
    """Passes on odometry as poses, at most 100 a second.

    Args:
        publisher: of our own poses.
    """

    def __init__(self, publisher: "Publisher") -> None:
        self._publisher = publisher
        self._throttle = Throttle(POSE_PERIOD_NS)
        self.refusals = Refusals("an odometry")
        self.poses = 0

    def hear(self, message: Message) -> None:
        """Take one message off the robot's wire; called on a thread of the bus. Never raises."""
        if not self._throttle.is_due(message.received_ns):
            return
        try:
            pose = decode_odometry(message.payload)
        except UnusableMessageError as error:
            self.refusals.count(str(error), message.received_ns)
            return
        self.poses += 1
        self._publisher.put(pose.SerializeToString(), message.received_ns)


class TransformRelay:
    """Passes on transforms, of each frame at most 20 a second; static ones again every second.

    Args:
        publisher: of our own transforms.
        mounts: learns the frames that never move.
    """

    def __init__(self, publisher: "Publisher", mounts: Mounts | None = None) -> None:
        self._publisher = publisher
        self._mounts = mounts
        self._lock = threading.Lock()  # two threads of the bus and the bridge's own come here
        self._throttles: dict[str, Throttle] = {}
        self._static: dict[str, FrameTransform] = {}
        self._budget = _Budget(READ_A_SECOND)
        self._again = Throttle(at_once=False)
        self.refusals = Refusals("a transform")
        self.transforms = 0

    def hear(self, message: Message) -> None:
        """Take a message of `/tf`; called on a thread of the bus. Never raises."""
        self._take(message, self._pass_on)

    def hear_static(self, message: Message) -> None:
        """Take a message of `/tf_static`; called on a thread of the bus. Never raises."""
        self._take(message, self._keep)

    def repeat(self, now_ns: int) -> None:
        """Say the static ones again if a second has passed."""
        if not self._again.is_due(now_ns):
            return
        with self._lock:
            for transform in self._static.values():
                self._put(transform, now_ns)

    def _take(self, message: Message, use: Callable[[FrameTransform, int], None]) -> None:
        with self._lock:
            if not self._budget.allows(message.received_ns):
                self.refusals.count(TOO_OFTEN)
                return
            try:
                for transform in decode_transforms(message.payload):
                    use(transform, message.received_ns)
            except UnusableMessageError as error:
                self.refusals.count(str(error), message.received_ns)

    def _pass_on(self, transform: FrameTransform, now_ns: int) -> None:
        throttle = self._throttles.get(transform.child_frame_id)
        if throttle is None:
            if len(self._throttles) == MAX_FRAMES:
                self.refusals.count(TOO_MANY)
                return
            throttle = self._throttles[transform.child_frame_id] = Throttle(TRANSFORM_PERIOD_NS)
        if throttle.is_due(now_ns):
            self._put(transform, now_ns)

    def _keep(self, transform: FrameTransform, now_ns: int) -> None:
        name = transform.child_frame_id
        if name not in self._static and len(self._static) == MAX_FRAMES:
            self.refusals.count(TOO_MANY)
            return
        self._static[name] = transform
        if self._mounts is not None:
            self._mounts.learn(transform)
        self._put(transform, now_ns)

    def _put(self, transform: FrameTransform, now_ns: int) -> None:
        self.transforms += 1
        self._publisher.put(transform.SerializeToString(), now_ns)


class _Budget:
    """So many messages in each second, and no more."""

    def __init__(self, a_second: int) -> None:
        self._a_second = a_second
        self._left = a_second
        self._second = Throttle()

    def allows(self, now_ns: int) -> bool:
        """Whether one more may be read."""
        if self._second.is_due(now_ns):
            self._left = self._a_second
        self._left -= 1
        return self._left >= 0
