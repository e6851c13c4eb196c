"""The topic table: every stream, its message, who publishes it, how often, whether recorded.

A key on the bus is `<robot>/<name>`, without a leading slash; the topic in a log is the same with
one. No other place defines topics.
"""

from dataclasses import dataclass
from enum import Enum

DEFAULT_ROBOT = "robot0"

RUNTIME_NODE = "runtime"
BODY_NODE = "body"


class Quality(Enum):
    """How a stream is sent."""

    CONTROL = "control"
    """Express, real-time priority, dropped rather than blocking."""
    DATA = "data"
    """Ordinary priority, dropped rather than blocking."""


@dataclass(frozen=True)
class Topic:
    """One stream."""

    name: str
    schema: str
    """Full name of the protobuf message."""
    publisher: str
    rate: str
    quality: Quality = Quality.DATA
    recorded: bool = True

    def key(self, robot: str) -> str:
        """Key on the bus."""
        return f"{robot}/{self.name}"


RETINA = Topic("retina", "foxglove.RawImage", "body", "sensor", Quality.CONTROL)
SCAN = Topic("scan", "foxglove.LaserScan", "body", "sensor", Quality.CONTROL)
COMMAND = Topic("command", "reflexarc.Command", "runtime", "tick", Quality.CONTROL)
TICK = Topic("tick", "reflexarc.Tick", "runtime", "tick")
STATUS = Topic("status", "reflexarc.Status", "runtime, body", "1 Hz")
POSE = Topic("pose", "foxglove.PoseInFrame", "body", "sensor")
TRANSFORM = Topic("tf", "foxglove.FrameTransform", "body", "sensor")
ODOMETRY = Topic("odometry", "foxglove.PoseInFrame", "body", "sensor")
SCENE = Topic("scene", "foxglove.SceneUpdate", "body", "1 Hz")
LOG = Topic("log", "foxglove.Log", "runtime, body", "event")
CONTACT = Topic("contact", "reflexarc.Contact", "body", "event")
REJECTED = Topic("rejected", "reflexarc.Rejected", "recorder", "event")

TOPICS: tuple[Topic, ...] = (
    RETINA,
    SCAN,
    COMMAND,
    TICK,
    STATUS,
    POSE,
    TRANSFORM,
    ODOMETRY,
    SCENE,
    LOG,
    CONTACT,
    REJECTED,
)
SENSORS: dict[str, Topic] = {"retina": RETINA, "scan": SCAN}
"""The streams that the runtime can decide on, by the value of `--input`."""

_BY_NAME = {topic.name: topic for topic in TOPICS}


def topic_of(key: str) -> Topic | None:
    """The topic that a key on the bus belongs to, whatever the robot; None if it is not ours."""
    return _BY_NAME.get(key.rpartition("/")[2])


def alive_key(robot: str, node: str) -> str:
    """Key of a node's liveliness token."""
    return f"{robot}/alive/{node}"


def policy_key(robot: str) -> str:
    """Key of the queryable that answers with the policy file."""
    return f"{robot}/policy"
