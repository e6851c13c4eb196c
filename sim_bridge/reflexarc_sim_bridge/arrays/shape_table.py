"""Shapes of obstacles as rows of a table that compiled code reads."""

import math
from collections.abc import Sequence

from reflexarc_sim_bridge.arrays.layout import BOX, CURVE, DISC, POLYGON, TURNED_BOX, Table
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles, Shape


def write_shapes(rows: Table, shapes: Sequence[Shape]) -> None:
    """Fill the rows of a layer's shapes.

    Args:
        rows: `SHAPE_DTYPE`: (shapes or more,).
        shapes: the layer's.
    """
    total, up_to = math.fsum(shape.share for shape in shapes), 0.0
    for number, shape in enumerate(shapes):
        row = rows[number : number + 1]
        up_to += shape.share / total
        row["share_up_to"] = up_to
        _write_shape(row, shape)


def _write_shape(row: Table, shape: Shape) -> None:
    match shape:
        case Rectangles():
            row["kind"] = TURNED_BOX if shape.is_turned else BOX
            row["size_low"], row["size_high"] = shape.width_m
            row["length_low"], row["length_high"] = shape.length_m
            row["turned_low"], row["turned_high"] = shape.turned_rad
        case Discs():
            row["kind"] = DISC
            row["size_low"], row["size_high"] = shape.radius_m
        case Polygons():
            row["kind"] = POLYGON
            row["size_low"], row["size_high"] = shape.radius_m
            row["turned_high"] = math.tau
            row["dent_low"], row["dent_high"] = shape.dent
            row["corners_low"], row["corners_high"] = shape.corners
        case Curves():
            row["kind"] = CURVE
            row["size_low"], row["size_high"] = shape.radius_m
            row["turned_high"] = math.tau
            row["dent_low"], row["dent_high"] = shape.waviness
