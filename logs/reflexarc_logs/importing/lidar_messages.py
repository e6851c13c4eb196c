"""Encodes scans and poses as Foxglove messages, byte for byte as protobuf does.

Setting the fields of a protobuf message one by one takes longer than encoding it. The messages of a
stream differ only in their time and a few numbers, so protobuf encodes one message of each kind as
a template, and these numbers are replaced in its bytes. The timestamp is the first field of all
three kinds, and the ranges are the last field of a scan: encoded fields, joined, are one message.
"""

import math
import re
import struct
from collections.abc import Callable
from functools import lru_cache, partial

import numpy as np
import numpy.typing as npt
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.importing.scan_line import Sweep, TimedPose
from reflexarc_runtime.sensing.mounting import CENTRED, Mount, pose_of

WORLD_FRAME = "world"
ODOMETRY_FRAME = "odom"

_LENGTH_DELIMITED = 2
_RANGES_TAG = bytes([LaserScan.RANGES_FIELD_NUMBER << 3 | _LENGTH_DELIMITED])
_FLOAT64 = struct.Struct("<d")


class LidarMessages:
    """Encodes the messages of one robot, whose name is the frame of its lidar.

    The messages keep the file's own times; a time of None is left out.
    """

    def __init__(self, robot: str) -> None:
        self._robot = robot
        self._poses = {
            frame: _PlanarForm(partial(_pose, frame)) for frame in (WORLD_FRAME, ODOMETRY_FRAME)
        }
        self._transform = _PlanarForm(partial(_transform, robot))

    def scan(self, sweep: Sweep) -> bytes:
        """`foxglove.LaserScan`."""
        fixed = _fixed_of_scan(self._robot, sweep.start_rad, sweep.end_rad, sweep.mount)
        return b"".join((_timestamp(sweep.time_ns), fixed, *_packed_ranges(sweep.ranges_m)))

    def pose(self, place: TimedPose, frame: str) -> bytes:
        """`foxglove.PoseInFrame`."""
        return _timestamp(place.time_ns) + self._poses[frame].cast(place)

    def transform(self, place: TimedPose) -> bytes:
        """`foxglove.FrameTransform` from the world to the robot."""
        return _timestamp(place.time_ns) + self._transform.cast(place)


class _PlanarForm:
    """A template of a message, without its time, in which only a planar pose changes.

    Args:
        encode: encodes the message with protobuf, from x, y, and z and w of a rotation about z.
    """

    _SAMPLE = (0.1, 0.2, 0.3, 0.4)

    def __init__(self, encode: Callable[[float, float, float, float], bytes]) -> None:
        self._encode = encode
        numbers = b"|".join(re.escape(_FLOAT64.pack(number)) for number in self._SAMPLE)
        self._fixed = re.split(numbers, encode(*self._SAMPLE))
        self._layout = struct.Struct("<" + "d".join(f"{len(part)}s" for part in self._fixed))

    def cast(self, place: TimedPose) -> bytes:
        """The bytes of the message for a pose."""
        x, y, half = place.x_m, place.y_m, place.heading_rad / 2
        z, w = math.sin(half), math.cos(half)
        if not (x and y and z and w):  # protobuf leaves out what is zero
            return self._encode(x, y, z, w)
        before_x, before_y, before_z, before_w, rest = self._fixed
        return self._layout.pack(before_x, x, before_y, y, before_z, z, before_w, w, rest)


def _pose(frame: str, x: float, y: float, z: float, w: float) -> bytes:
    message = PoseInFrame(frame_id=frame)
    message.pose.position.x, message.pose.position.y = x, y
    message.pose.orientation.z, message.pose.orientation.w = z, w
    return message.SerializeToString()


def _transform(robot: str, x: float, y: float, z: float, w: float) -> bytes:
    message = FrameTransform(parent_frame_id=WORLD_FRAME, child_frame_id=robot)
    message.translation.x, message.translation.y = x, y
    message.rotation.z, message.rotation.w = z, w
    return message.SerializeToString()


@lru_cache(maxsize=1)
def _fixed_of_scan(robot: str, start_rad: float, end_rad: float, mount: Mount) -> bytes:
    """All fields of a scan between its timestamp and its ranges."""
    scan = LaserScan(frame_id=robot, start_angle=start_rad, end_angle=end_rad)
    if mount == CENTRED:
        scan.pose.orientation.w = 1.0
    else:
        scan.pose.CopyFrom(pose_of(mount))
    return scan.SerializeToString()


@lru_cache(maxsize=1)  # the messages of one line have one time
def _timestamp(time_ns: int | None) -> bytes:
    """The field `timestamp`, the same in all three kinds."""
    message = LaserScan()
    seconds_and_nanos = divmod(time_ns or 0, 1_000_000_000)
    message.timestamp.seconds, message.timestamp.nanos = seconds_and_nanos
    return message.SerializeToString()


def _packed_ranges(ranges_m: npt.NDArray[np.float64]) -> tuple[bytes, bytes, bytes]:
    """The wire form of the field `ranges`: its tag, its length, little-endian float64.

    Protobuf would take each number out of a Python list.
    """
    data = ranges_m.tobytes()
    return _RANGES_TAG, _varint(len(data)), data


def _varint(value: int) -> bytes:
    """A number of the protobuf wire: seven bits a byte, the lowest first."""
    encoded = bytearray()
    while value > 0x7F:
        encoded.append(value & 0x7F | 0x80)
        value >>= 7
    encoded.append(value)
    return bytes(encoded)
