"""Messages for viewers: a body's pose, its transform, and the obstacles around it."""

import math
from collections.abc import Sequence

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.CylinderPrimitive_pb2 import CylinderPrimitive
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3

from reflexarc_runtime.messages.codec import timestamp
from reflexarc_sim_bridge.body.body import BodyPose
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.stripe_outlines import Stripe

WORLD_FRAME = "world"
OBSTACLE_HEIGHT_M = 0.5
GRAIN_M = 2.0**-10
"""Of what a scene shows: a millimetre. Numbers with few digits leave half as much in a log; what
the obstacles truly are follows from the world."""


def encode_pose(place: BodyPose, time_ns: int) -> bytes:
    """`foxglove.PoseInFrame` in the world's frame."""
    pose = Pose(
        position=_point(place.x_m, place.y_m, 0.0), orientation=_rotation(place.heading_rad)
    )
    message = PoseInFrame(timestamp=timestamp(time_ns), frame_id=WORLD_FRAME, pose=pose)
    return message.SerializeToString()


def encode_transform(place: BodyPose, robot: str, time_ns: int) -> bytes:
    """`foxglove.FrameTransform` from the world to the robot."""
    message = FrameTransform(
        timestamp=timestamp(time_ns),
        parent_frame_id=WORLD_FRAME,
        child_frame_id=robot,
        translation=_point(place.x_m, place.y_m, 0.0),
        rotation=_rotation(place.heading_rad),
    )
    return message.SerializeToString()


def encode_scene(outlines: Sequence[Outline], time_ns: int) -> bytes:
    """`foxglove.SceneUpdate`: one entity, which replaces the previous one."""
    entity = SceneEntity(
        timestamp=timestamp(time_ns),
        frame_id=WORLD_FRAME,
        id="obstacles",
        cubes=[_cube(outline) for outline in outlines if outline.is_box],
        cylinders=[_cylinder(outline) for outline in outlines if outline.is_disc],
        triangles=[
            _fan(piece)
            for outline in outlines
            if not outline.is_box and not outline.is_disc
            for piece in outline.stripes or (outline,)
        ],
    )
    return SceneUpdate(entities=[entity]).SerializeToString()


def _cube(box: Outline) -> CubePrimitive:
    length_m, width_m = np.ptp(box.corners_m, axis=0).tolist()
    size = _shown(length_m, width_m, OBSTACLE_HEIGHT_M)
    return CubePrimitive(pose=_pose_of(box), size=size, color=_paint(box.colour))


def _cylinder(disc: Outline) -> CylinderPrimitive:
    size = _shown(2 * disc.radius_m, 2 * disc.radius_m, OBSTACLE_HEIGHT_M)
    return CylinderPrimitive(
        pose=_pose_of(disc), size=size, bottom_scale=1.0, top_scale=1.0, color=_paint(disc.colour)
    )


def _fan(polygon: Outline | Stripe) -> TriangleListPrimitive:
    """Triangles from the middle to every side, which works as all outlines are star-shaped.

    Points: the middle, then the corners.
    """
    n = len(polygon.corners_m)
    points = [polygon.corners_m.mean(axis=0).tolist(), *polygon.corners_m.tolist()]
    return TriangleListPrimitive(
        pose=Pose(position=_point(0.0, 0.0, 0.0), orientation=_rotation(0.0)),
        points=[Point3(x=_coarse(x), y=_coarse(y), z=OBSTACLE_HEIGHT_M) for x, y in points],
        indices=[index for k in range(n) for index in (0, k + 1, (k + 1) % n + 1)],
        color=_paint(polygon.colour),
    )


def _pose_of(outline: Outline) -> Pose:
    centre = _shown(outline.x_m, outline.y_m, OBSTACLE_HEIGHT_M / 2)
    return Pose(position=centre, orientation=_rotation(0.0))


def _paint(colour: tuple[float, float, float]) -> Color:
    """A colour for display: white, as most obstacles are, becomes a blue for white grounds."""
    red, green, blue = colour
    return Color(r=0.30 * red, g=0.45 * green, b=0.65 * blue, a=1.0)


def _rotation(heading_rad: float) -> Quaternion:
    """About z, counter-clockwise."""
    return Quaternion(x=0.0, y=0.0, z=math.sin(heading_rad / 2), w=math.cos(heading_rad / 2))


def _point(x: float, y: float, z: float) -> Vector3:
    return Vector3(x=x, y=y, z=z)


def _shown(x: float, y: float, z: float) -> Vector3:
    return _point(_coarse(x), _coarse(y), z)


def _coarse(length_m: float) -> float:
    return round(length_m / GRAIN_M) * GRAIN_M
