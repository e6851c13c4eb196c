"""Which topics of a bag become which streams of a log, and how each message is read.

One `LaserScan` becomes `scan`, one `Odometry` becomes `odometry`, every transform `tf`. Pictures
keep their topic, behind the robot's name: they are no retinas, for no eye made them. Further
scanners keep theirs as well.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import Message

from reflexarc_logs.bags.bag_file import BagTopic
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages import topics
from reflexarc_runtime.ros2.frames import decode_odometry, decode_transforms
from reflexarc_runtime.ros2.images import decode_compressed, decode_image
from reflexarc_runtime.ros2.laser_scan import STANDARD, RosScanner, decode_scan, encode_scan
from reflexarc_runtime.ros2.mounts import BASE
from reflexarc_runtime.ros2.ros_types import (
    COMPRESSED_IMAGE,
    IMAGE,
    LASER_SCAN,
    ODOMETRY,
    TF_MESSAGE,
)
from reflexarc_runtime.sensing.mounting import Mount

STATIC = "tf_static"
"""Transforms that never change, in a bag and in the log: they are said once."""

MountIn = Callable[[str], Mount | None]
"""How a scanner of a frame sits on the robot; None if nobody said it."""

Reading = Callable[[bytes], Iterable[bytes]]


@dataclass(frozen=True)
class BagStream:
    """A topic of a bag that a log takes in."""

    source: BagTopic
    topic: str
    """In the log: "/robot0/scan"."""
    kind: type[Message]
    """What it carries there."""
    read: Reading
    """The messages that one of the bag's becomes. May raise `UnusableMessageError`."""


@dataclass(frozen=True)
class BagWishes:
    """What somebody wants of a bag."""

    robot: str = topics.DEFAULT_ROBOT
    scan: str = ""
    """The topic that becomes `scan`; empty: the only one with scans, else `/scan`."""
    odometry: str = ""
    """The topic that becomes `odometry`; empty: the only one with odometry, else `/odom`."""
    scanner: RosScanner = STANDARD
    """What is known of the scanner beside."""
    base: str = BASE
    """The robot's own frame, on which its scanners sit."""


def streams_of(
    bag: Iterable[BagTopic], wishes: BagWishes, mount_in: MountIn
) -> tuple[BagStream, ...]:
    """What a log takes in of a bag.

    Args:
        bag: its topics.
        wishes: which of them are the robot's own scan and odometry.
        mount_in: how its scanners sit.

    Raises:
        UsageError: several topics could be the scan, or the one that is named has none.
    """
    known = tuple(bag)
    scan = _chosen(known, LASER_SCAN.name, wishes.scan, "/scan", "--scan")
    odometry = _chosen(known, ODOMETRY.name, wishes.odometry, "/odom", "--odometry")
    made = (_stream(topic, scan, odometry, wishes, mount_in) for topic in known)
    return tuple(stream for stream in made if stream is not None)


def _chosen(
    bag: tuple[BagTopic, ...], type_name: str, asked: str, usual: str, flag: str
) -> BagTopic | None:
    """The topic that somebody asked for, else the only one of its type, else the usual one."""
    found = [topic for topic in bag if topic.type_name == type_name]
    names = ", ".join(topic.name for topic in found) or "none"
    wanted = f"/{asked.removeprefix('/')}" if asked else usual
    for topic in found:
        if topic.name == wanted:
            return topic
    if asked:
        raise UsageError(f"{flag} {asked}: expected a topic of {type_name}, the bag has {names}")
    if len(found) > 1:
        raise UsageError(f"the bag has several topics of {type_name}: {names}; choose with {flag}")
    return found[0] if found else None


def _stream(
    topic: BagTopic,
    scan: BagTopic | None,
    odometry: BagTopic | None,
    wishes: BagWishes,
    mount_in: MountIn,
) -> BagStream | None:
    def stream(name: str, kind: type[Message], read: Reading) -> BagStream:
        return BagStream(topic, f"/{wishes.robot}/{name.removeprefix('/')}", kind, read)

    name = topic.name
    match topic.type_name:
        case LASER_SCAN.name if topic == scan:
            return stream(
                topics.SCAN.name, LaserScan, _scans(wishes.scanner, mount_in, wishes.base)
            )
        case LASER_SCAN.name:
            return stream(_beside(name), LaserScan, _scans(STANDARD, mount_in, wishes.base))
        case ODOMETRY.name if topic == odometry:
            return stream(topics.ODOMETRY.name, PoseInFrame, _one(decode_odometry))
        case ODOMETRY.name:
            return stream(_beside(name), PoseInFrame, _one(decode_odometry))
        case TF_MESSAGE.name if name == f"/{STATIC}":
            return stream(STATIC, FrameTransform, _transforms)
        case TF_MESSAGE.name:
            return stream(topics.TRANSFORM.name, FrameTransform, _transforms)
        case IMAGE.name:
            return stream(_beside(name), RawImage, _one(decode_image))
        case COMPRESSED_IMAGE.name:
            return stream(_beside(name), CompressedImage, _one(decode_compressed))
    return None


def _beside(name: str) -> str:
    """The name of a topic that is not one of ours, and must not be taken for one."""
    plain = name.removeprefix("/")
    ours = {topic.name for topic in topics.TOPICS}
    return f"ros/{plain}" if plain in ours else plain


def _scans(scanner: RosScanner, mount_in: MountIn, base: str) -> Reading:
    return lambda payload: (encode_scan(decode_scan(payload, scanner, mount_in), base),)


def _one(decode: Callable[[bytes], Message]) -> Reading:
    return lambda payload: (decode(payload).SerializeToString(),)


def _transforms(payload: bytes) -> Iterable[bytes]:
    return [transform.SerializeToString() for transform in decode_transforms(payload)]
