"""The obstacles of `foxglove.SceneUpdate` as boxes, discs and triangles."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity

from reflexarc_logs.viewing.drawings import (
    SCENE,
    Colours,
    DrawnBoxes,
    DrawnDiscs,
    DrawnTriangles,
    Places,
)


def shapes_of(entities: Iterable[SceneEntity]) -> tuple[DrawnBoxes, DrawnDiscs, DrawnTriangles]:
    """All that the entities show; of a kind that none of them has, nothing is drawn any more."""
    known = tuple(entities)
    cubes = [cube for entity in known for cube in entity.cubes]
    cylinders = [cylinder for entity in known for cylinder in entity.cylinders]
    return (
        DrawnBoxes(
            f"{SCENE}/boxes",
            _places([cube.pose.position for cube in cubes]),
            _places([cube.size for cube in cubes]),
            _colours([cube.color for cube in cubes]),
        ),
        DrawnDiscs(
            f"{SCENE}/discs",
            _places([cylinder.pose.position for cylinder in cylinders]),
            np.array([0.5 * cylinder.size.x for cylinder in cylinders], np.float64),
            np.array([cylinder.size.z for cylinder in cylinders], np.float64),
            _colours([cylinder.color for cylinder in cylinders]),
        ),
        _triangles([fan for entity in known for fan in entity.triangles]),
    )


def _triangles(lists: Sequence[Any]) -> DrawnTriangles:
    """The corners of all lists, one after another, so that each has its list's colour."""
    corners: list[Any] = []
    colours: list[Any] = []
    for one in lists:
        count = len(one.points)
        picked = [one.points[i] for i in one.indices if i < count] or list(one.points)
        picked = picked[: len(picked) // 3 * 3]
        corners += picked
        colours += [one.color] * len(picked)
    return DrawnTriangles(f"{SCENE}/triangles", _places(corners), _colours(colours))


def _places(points: Iterable[Any]) -> Places:
    return np.array([(p.x, p.y, p.z) for p in points], np.float64).reshape(-1, 3)


def _colours(colours: Iterable[Any]) -> Colours:
    parts = np.array([(c.r, c.g, c.b, c.a) for c in colours], np.float64).reshape(-1, 4)
    return (255.0 * np.clip(np.nan_to_num(parts), 0.0, 1.0)).round().astype(np.uint8)
