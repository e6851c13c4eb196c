"""What the viewers show of a body: its pose, its transform, and the obstacles around it."""

import numpy as np
import numpy.typing as npt
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.CylinderPrimitive_pb2 import CylinderPrimitive
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from reflexarc_runtime.messages import timestamp
from reflexarc_sim_bridge.body import Place

WORLD_FRAME = "world"
OBSTACLE_HEIGHT_M = 0.5

_NO_ROTATION = Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)


def encode_pose(place: Place, time_ns: int) -> bytes:
    """`foxglove.PoseInFrame` in the world's frame."""
    pose = Pose(position=_point(place.x_m, place.y_m, 0.0), orientation=_NO_ROTATION)
    message = PoseInFrame(timestamp=timestamp(time_ns), frame_id=WORLD_FRAME, pose=pose)
    return message.SerializeToString()


def encode_transform(place: Place, robot: str, time_ns: int) -> bytes:
    """`foxglove.FrameTransform` from the world to the robot."""
    message = FrameTransform(
        timestamp=timestamp(time_ns),
        parent_frame_id=WORLD_FRAME,
        child_frame_id=robot,
        translation=_point(place.x_m, place.y_m, 0.0),
        rotation=_NO_ROTATION,
    )
    return message.SerializeToString()


def encode_scene(obstacles: npt.NDArray[np.void], time_ns: int) -> bytes:
    """`foxglove.SceneUpdate`: one entity that replaces the one before.

    Args:
        obstacles: array of `OBSTACLE_DTYPE`: (count,).
        time_ns: on the body's clock.
    """
    entity = SceneEntity(
        timestamp=timestamp(time_ns),
        frame_id=WORLD_FRAME,
        id="obstacles",
        cubes=[_cube(obstacle) for obstacle in obstacles if not obstacle["round"]],
        cylinders=[_cylinder(obstacle) for obstacle in obstacles if obstacle["round"]],
    )
    return SceneUpdate(entities=[entity]).SerializeToString()


def _cube(obstacle: np.void) -> CubePrimitive:
    return CubePrimitive(
        pose=_pose_of(obstacle), size=_size_of(obstacle), color=_paint(float(obstacle["colour"]))
    )


def _cylinder(obstacle: np.void) -> CylinderPrimitive:
    return CylinderPrimitive(
        pose=_pose_of(obstacle),
        size=_size_of(obstacle),
        bottom_scale=1.0,
        top_scale=1.0,
        color=_paint(float(obstacle["colour"])),
    )


def _pose_of(obstacle: np.void) -> Pose:
    centre = _point(float(obstacle["x_m"]), float(obstacle["y_m"]), OBSTACLE_HEIGHT_M / 2)
    return Pose(position=centre, orientation=_NO_ROTATION)


def _size_of(obstacle: np.void) -> Vector3:
    length_m, width_m = 2 * obstacle["half_length_m"], 2 * obstacle["half_width_m"]
    return _point(float(length_m), float(width_m), OBSTACLE_HEIGHT_M)


def _paint(colour: float) -> Color:
    return Color(r=0.30 * colour, g=0.45 * colour, b=0.65 * colour, a=1.0)


def _point(x: float, y: float, z: float) -> Vector3:
    return Vector3(x=x, y=y, z=z)
