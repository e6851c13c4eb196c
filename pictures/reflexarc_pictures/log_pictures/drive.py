"""Draws a drive: from above, and what the policy saw and did as strips over time.

Above: obstacles, path and contacts, x ahead to the right, y to the left upwards. Without poses
there is no view from above.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.CubePrimitive_pb2 import CubePrimitive
from foxglove_schemas_protobuf.CylinderPrimitive_pb2 import CylinderPrimitive
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch, Polygon, Rectangle

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.log_pictures.decision_strips import INK, Decisions
from reflexarc_pictures.log_pictures.logged_poses import Floats, are_places, poses_of
from reflexarc_pictures.log_pictures.panels import Panels
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import CONTACT, SCENE

OBSTACLE_COLOUR, CONTACT_COLOUR = "#9fb3c8", "#f2a900"
MARGIN_M = 4.0
JUMP_M = 0.5
"""A body does not drive as far within a tick: it was placed elsewhere."""
Extent = tuple[float, float, float, float]
"""Centre x and y, length along x, width along y."""


@dataclass(frozen=True)
class Drive:
    """What a picture of a drive shows."""

    title: str
    x_m: Floats
    """Path ahead: (poses,)."""
    y_m: Floats
    """Path to the left, within the world's period: (poses,)."""
    contacts: Floats
    """Where collisions began, x and y: (contacts, 2)."""
    boxes: Floats
    """Rectangles: centre x and y, length along x, width along y: (boxes, 4)."""
    discs: Floats
    """Discs: the same with the diameter twice: (discs, 4)."""
    polygons: Sequence[Floats]
    """Corners of other obstacles, each (corners, 2)."""
    decisions: Decisions


def draw_drive(drive: Drive, path: Path) -> None:
    """Write the picture as PNG."""
    if not len(drive.x_m):
        Panels(drive.decisions, None).save(path, f"{drive.title}, no poses")
        return
    lowest_m = np.array([drive.x_m.min(), drive.y_m.min()]) - MARGIN_M
    highest_m = np.array([drive.x_m.max(), drive.y_m.max()]) + MARGIN_M
    width_m, height_m = (highest_m - lowest_m).tolist()
    panels = Panels(drive.decisions, (width_m, height_m))
    assert panels.map is not None
    contacts = _draw_from_above(panels.map, drive)
    panels.map.set(xlim=(lowest_m[0], highest_m[0]), ylim=(lowest_m[1], highest_m[1]))
    panels.map.set_aspect("equal", adjustable="box")
    panels.map.set(xlabel="ahead (m)", ylabel="to the left (m)")
    panels.save(path, drive.title, contacts)


def drive_of(log: Log, decisions: Decisions) -> Drive:
    """Path, contacts and obstacles, each as far as the log has them.

    Raises:
        LogError: the log is damaged.
    """
    places = poses_of(log).places
    boxes, discs, polygons = _obstacles(log)
    return Drive(
        title=f"{log.path.name}: {len(decisions.time_s)} decisions",
        x_m=places[:, 0],
        y_m=places[:, 1],
        contacts=_contacts(log),
        boxes=boxes,
        discs=discs,
        polygons=polygons,
        decisions=decisions,
    )


def _draw_from_above(axes: Axes, drive: Drive) -> list[Line2D]:
    """Draw obstacles, path and contacts; return the legend's entry for contacts, if any."""
    shapes: list[Patch] = [
        Rectangle((x - length / 2, y - width / 2), length, width)
        for x, y, length, width in drive.boxes
    ]
    shapes += [Ellipse((x, y), length, width) for x, y, length, width in drive.discs]
    shapes += [Polygon(corners_m) for corners_m in drive.polygons]
    axes.add_collection(PatchCollection(shapes, facecolor=OBSTACLE_COLOUR, edgecolor="none"))
    axes.plot(*_broken_at_jumps(drive.x_m, drive.y_m), color=INK, linewidth=1.6)
    if not len(drive.contacts):
        return []
    label = f"contact: {len(drive.contacts)}"
    return axes.plot(*drive.contacts.T, "o", color=CONTACT_COLOUR, markeredgecolor=INK, label=label)


def _broken_at_jumps(x_m: Floats, y_m: Floats) -> tuple[Floats, Floats]:
    """The path with gaps where the body was placed elsewhere or the world repeats."""
    jumps = np.flatnonzero(np.abs(np.diff(y_m)) > JUMP_M) + 1
    return np.insert(x_m, jumps, np.nan), np.insert(y_m, jumps, np.nan)


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
    outlines = [
        _rows(corners, 2) for corners in sorted(polygons) if len(_rows(corners, 2)) == len(corners)
    ]
    return _rows(sorted(boxes), 4), _rows(sorted(discs), 4), outlines


def _extent(shape: CubePrimitive | CylinderPrimitive) -> Extent:
    position, size = shape.pose.position, shape.size
    return (position.x, position.y, size.x, size.y)


def _corners(shape: TriangleListPrimitive) -> tuple[tuple[float, float], ...]:
    """All points but the first, which is the centre of a fan."""
    return tuple((point.x, point.y) for point in shape.points[1:])


def _rows(rows: object, columns: int) -> Floats:
    """Those rows that a picture can show."""
    table = np.array(rows, np.float64).reshape(-1, columns)
    return table[are_places(table)]
