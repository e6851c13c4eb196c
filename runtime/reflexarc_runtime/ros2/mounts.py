"""How a robot's scanner sits, by what the robot says of its frames that never move (`/tf_static`).

A transform takes a point from the child's frame to the parent's (tf2). From the scanner's frame up
to the robot's base they are put together: p ↦ R₂ (R₁ p + t₁) + t₂.
"""

import logging

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Pose_pb2 import Pose

from reflexarc_runtime.ros2.cdr import SECOND_NS
from reflexarc_runtime.sensing.mounting import Mount, mount_of

BASE = "base_link"
"""The frame whose x is ahead, about whose origin the robot turns (REP 105)."""
MOST_STEPS = 64
PATIENCE_NS = 3 * SECOND_NS
"""How long a robot may take to say how its frames are."""

_LOG = logging.getLogger(__name__)

Numbers = tuple[float, float, float]
Turn = tuple[float, float, float, float]
"""A unit quaternion: x, y, z, w."""


class Mounts:
    """The fixed frames of a robot, and how a scanner of one of them sits.

    Args:
        base: name of the robot's own frame.
    """

    def __init__(self, base: str = BASE) -> None:
        self.base = base
        self._known: dict[str, FrameTransform] = {}
        self._asked_ns: int | None = None
        self._has_said = False

    def learn(self, transform: FrameTransform) -> None:
        """Take a transform that never changes; how many there may be is the caller's affair."""
        self._known[transform.child_frame_id] = transform

    def of(self, frame: str, now_ns: int) -> Mount | None:
        """How a scanner of that frame sits; None: the robot has not said it.

        Raises:
            UnusableScanError: it is tilted, so that it does not scan along the ground.
        """
        pose = self._pose(frame.removeprefix("/"))
        if pose is None:
            self._say(frame, now_ns)
            return None
        return mount_of(pose)

    def _pose(self, frame: str) -> Pose | None:
        place: Numbers = (0.0, 0.0, 0.0)
        turn: Turn = (0.0, 0.0, 0.0, 1.0)
        for _ in range(MOST_STEPS):
            if frame == self.base:
                return _pose(place, turn)
            step = self._known.get(frame)
            if step is None:
                return None
            rotation: Turn = (step.rotation.x, step.rotation.y, step.rotation.z, step.rotation.w)
            shift = step.translation
            turned = rotated(rotation, place)
            place = (turned[0] + shift.x, turned[1] + shift.y, turned[2] + shift.z)
            turn, frame = multiplied(rotation, turn), step.parent_frame_id
        return None

    def _say(self, frame: str, now_ns: int) -> None:
        if self._asked_ns is None:
            self._asked_ns = now_ns
        if self._has_said or now_ns - self._asked_ns < PATIENCE_NS:
            return
        self._has_said = True
        _LOG.warning(
            "the robot does not say how %r sits on %r: taken to be in its middle and to look "
            "ahead; --mount X Y DEGREES says otherwise",
            frame[:80],
            self.base,
        )


def rotated(turn: Turn, point: Numbers) -> Numbers:
    """A point turned by a unit quaternion: p + 2 w (q × p) + 2 q × (q × p)."""
    q, w = turn[:3], turn[3]
    once = _cross(q, point)
    twice = _cross(q, once)
    x, y, z = (p + 2.0 * (w * a + b) for p, a, b in zip(point, once, twice, strict=True))
    return x, y, z


def multiplied(a: Turn, b: Turn) -> Turn:
    """The turn that is b first, then a: the Hamilton product a b."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


def _cross(a: Numbers, b: Numbers) -> Numbers:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def _pose(place: Numbers, turn: Turn) -> Pose:
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = place
    pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w = turn
    return pose
