"""The topic table: every stream, its message, who publishes it, how often, whether recorded.

A key on the bus is `<robot>/<name>`, without a leading slash; the topic in a log is the same with
one. No other place defines topics.
"""

from dataclasses import dataclass
from enum import Enum

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import Message

from reflexarc_runtime import messages_pb2 as pb

DEFAULT_ROBOT = "robot0"

RUNTIME_NODE = "runtime"
BODY_NODE = "body"
RECORDER_NODE = "recorder"
OPERATOR = "operator"


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
    message: type[Message]
    """The protobuf message that it carries."""
    publishers: tuple[str, ...]
    """The nodes that publish it."""
    rate: str
    quality: Quality = Quality.DATA
    recorded: bool = True

    @property
    def schema(self) -> str:
        """Full name of the message."""
        return self.message.DESCRIPTOR.full_name

    def key(self, robot: str) -> str:
        """Key on the bus."""
        return f"{robot}/{self.name}"


RETINA = Topic("retina", RawImage, (BODY_NODE,), "sensor", Quality.CONTROL)
SCAN = Topic("scan", LaserScan, (BODY_NODE,), "sensor", Quality.CONTROL)
COMMAND = Topic("command", pb.Command, (RUNTIME_NODE,), "tick", Quality.CONTROL)
TICK = Topic("tick", pb.Tick, (RUNTIME_NODE,), "tick")
STATUS = Topic("status", pb.Status, (RUNTIME_NODE, BODY_NODE), "1 Hz")
POSE = Topic("pose", PoseInFrame, (BODY_NODE,), "sensor")
TRANSFORM = Topic("tf", FrameTransform, (BODY_NODE,), "10 Hz")
ODOMETRY = Topic("odometry", PoseInFrame, (BODY_NODE,), "sensor")
IMAGE = Topic("image", CompressedImage, (BODY_NODE,), "if asked for")
SCENE = Topic("scene", SceneUpdate, (BODY_NODE,), "0.5 Hz")
LOG = Topic("log", Log, (RUNTIME_NODE, BODY_NODE), "event")
CONTACT = Topic("contact", pb.Contact, (BODY_NODE,), "event")
BODY = Topic("body", pb.Body, (BODY_NODE,), "0.5 Hz")
STOP = Topic("stop", pb.Stop, (RUNTIME_NODE, OPERATOR), "event", Quality.CONTROL)
RESET = Topic("reset", pb.Reset, (OPERATOR,), "event", Quality.CONTROL)
ARM = Topic("arm", pb.Arm, (OPERATOR,), "event", Quality.CONTROL)
HOLD_TO_RUN = Topic("hold_to_run", pb.HoldToRun, (OPERATOR,), "20 Hz", Quality.CONTROL)
RELEASE = Topic("release", pb.Release, (RUNTIME_NODE, OPERATOR), "event", Quality.CONTROL)
OVERRUN = Topic("overrun", pb.Overrun, (RUNTIME_NODE,), "event", Quality.CONTROL)
SWAP = Topic("swap", pb.Swap, (RUNTIME_NODE,), "event")
SHADOW = Topic("shadow", pb.Shadow, (RUNTIME_NODE,), "tick")
MARK = Topic("mark", Log, (OPERATOR,), "event")
LEASE = Topic("lease", pb.Lease, (BODY_NODE,), "10 Hz", Quality.CONTROL)
KEYFRAME = Topic("keyframe", pb.Keyframe, (RECORDER_NODE,), "1 Hz")
REJECTED = Topic("rejected", pb.Rejected, (RECORDER_NODE,), "event")

TOPICS: tuple[Topic, ...] = (
    RETINA,
    SCAN,
    COMMAND,
    TICK,
    STATUS,
    POSE,
    TRANSFORM,
    ODOMETRY,
    IMAGE,
    SCENE,
    LOG,
    CONTACT,
    BODY,
    STOP,
    RESET,
    ARM,
    HOLD_TO_RUN,
    RELEASE,
    OVERRUN,
    SWAP,
    SHADOW,
    MARK,
    LEASE,
    KEYFRAME,
    REJECTED,
)
SENSORS: dict[str, Topic] = {"retina": RETINA, "scan": SCAN}
"""The streams that the runtime can decide on, by the value of `--input`."""
CONTROLS = (STOP, RESET, OVERRUN, SWAP)
"""The streams beside the sensor's that decide: they reach the loop through its inbox."""
RECORDERS_OWN = (KEYFRAME, REJECTED)
"""The streams that only a recorder writes: they are in logs, never on the bus."""
ON_THE_BUS = tuple(topic for topic in TOPICS if topic.recorded and topic not in RECORDERS_OWN)
"""The streams that are recorded as they are on the bus."""

BODY_TOPICS = tuple(
    topic for topic in TOPICS if topic.publishers == (BODY_NODE,) and topic is not LEASE
)
"""The streams that only a body publishes, and that are true of a log that is played as well: `play`
sends these out again."""
OVERHEARD = tuple(
    topic
    for topic in ON_THE_BUS
    if {BODY_NODE, OPERATOR} & {*topic.publishers} and topic not in (*SENSORS.values(), *CONTROLS)
)
"""The streams that `run --record` records beside what its loop receives and decides."""

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


def swap_key(robot: str) -> str:
    """Key of the queryable that takes another policy; nobody hears what is published."""
    return f"{robot}/swap_request"
