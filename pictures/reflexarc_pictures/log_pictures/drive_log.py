"""What a log says about a drive among obstacles that the body told of."""

import numpy as np
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.CylinderPrimitive_pb2 import CylinderPrimitive
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.log_pictures.decision_strips import Decisions, Floats
from reflexarc_pictures.log_pictures.drive import Drive
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import CONTACT, POSE, SCENE

Extent = tuple[float, float, float, float]
"""Centre x and y, length along x, width along y."""


def drive_of(log: Log, decisions: Decisions) -> Drive:
    """Path, contacts and obstacles, each as far as the log has them.

    Raises:
        LogError: the log is damaged.
    """
    poses = _poses(log)
    boxes, discs, polygons = _obstacles(log)
    return Drive(
        title=f"{log.path.name}: {len(decisions.time_s)} decisions",
        x_m=poses[:, 0],
        y_m=poses[:, 1],
        contacts=_contacts(log),
        boxes=boxes,
        discs=discs,
        polygons=polygons,
        decisions=decisions,
    )


def _poses(log: Log) -> Floats:
    positions = [m.pose.position for _, m in log.messages(log.topic(POSE.name), PoseInFrame)]
    return _rows([[p.x, p.y] for p in positions], 2)


def _contacts(log: Log) -> Floats:
    began = log.messages(log.topic(CONTACT.name), pb.Contact)
    return _rows([[contact.x_m, contact.y_m] for _, contact in began], 2)


def _obstacles(log: Log) -> tuple[Floats, Floats, list[Floats]]:
    """Every obstacle that any scene showed, once: boxes, discs, and corners of polygons."""
    boxes: set[Extent] = set()
    discs: set[Extent] = set()
    polygons: set[tuple[tuple[float, float], ...]] = set()
    for _, scene in log.messages(log.topic(SCENE.name), SceneUpdate):
        for entity in scene.entities:
            boxes.update(_extent(shape) for shape in entity.cubes)
            discs.update(_extent(shape) for shape in entity.cylinders)
            polygons.update(_corners(shape) for shape in entity.triangles)
    outlines = [_rows(corners, 2) for corners in sorted(polygons)]
    return _rows(sorted(boxes), 4), _rows(sorted(discs), 4), outlines


def _extent(shape: CubePrimitive | CylinderPrimitive) -> Extent:
    position, size = shape.pose.position, shape.size
    return (position.x, position.y, size.x, size.y)


def _corners(shape: TriangleListPrimitive) -> tuple[tuple[float, float], ...]:
    """All points but the first, which is the middle of a fan."""
    return tuple((point.x, point.y) for point in shape.points[1:])


def _rows(rows: object, columns: int) -> Floats:
    return np.array(rows, np.float64).reshape(-1, columns)
