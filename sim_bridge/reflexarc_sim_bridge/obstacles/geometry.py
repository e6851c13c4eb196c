"""Where a straight path first meets an obstacle: the one geometry of eyes and of bodies.

The path starts at the origin and goes along a unit vector (ahead, left); the obstacle lies at
(x, y). All lengths in metres. A path that starts inside meets it at 0. Where the path does not meet
it, the length is infinity.
Rays come in float32, motion in float64; the functions are compiled for either. Many rays meet the
faces of turned boxes and polygons in a form of their own: `faces.py`.

Box: the path is inside the slab |x − s·ahead| ≤ half_length between two lengths s, inside the
other slab between two more; it meets where both are (Kay and Kajiya's slabs).
Disc: h² = r² − (x·left − y·ahead)² is the squared half chord, s = x·ahead + y·left ∓ h.
Side of a polygon, from its corner p along e, counter-clockwise: s d = p + u e, so s = p×e / d×e
and u = p×d / d×e; it meets from outside (d×e < 0) where 0 ≤ u ≤ 1. The ends get a little more, so
that no path slips through where two sides meet.
No branch inside, so that the compiler turns a loop over rays into vector instructions.
"""

import math
from typing import Any, TypeAlias

import numpy as np

from reflexarc_sim_bridge.native.decorators import compiled_inline

Real: TypeAlias = Any
"""float or np.float32."""

# float32, so that arithmetic on float32 stays in float32 and on float64 in float64.
_ZERO = np.float32(0.0)
_NEVER = np.float32(np.inf)
_LITTLE = np.float32(1e-6)
_MORE = np.float32(1.0 + 1e-6)


@compiled_inline
def meets_box_m(
    x: Real, y: Real, half_length: Real, half_width: Real, per_ahead: Real, per_left: Real
) -> Real:
    """Length of the path up to an upright rectangle.

    `per_ahead` is 1/ahead, `per_left` 1/left, both finite.
    """
    middle_x, reach_x = x * per_ahead, half_length * math.fabs(per_ahead)
    middle_y, reach_y = y * per_left, half_width * math.fabs(per_left)
    enters_x, leaves_x = middle_x - reach_x, middle_x + reach_x
    enters_y, leaves_y = middle_y - reach_y, middle_y + reach_y
    enters = enters_x if enters_x > enters_y else enters_y
    leaves = leaves_x if leaves_x < leaves_y else leaves_y
    return _first(enters, leaves)


@compiled_inline
def turned_back(x: Real, y: Real, cos: Real, sin: Real) -> tuple[Real, Real]:
    """Rotate a vector by minus an angle, given its cosine and sine."""
    return x * cos + y * sin, y * cos - x * sin


@compiled_inline
def meets_disc_m(x: Real, y: Real, radius: Real, ahead: Real, left: Real) -> Real:
    """Length of the path up to a disc."""
    beside = x * left - y * ahead
    half_chord_2 = radius * radius - beside * beside
    half_chord = math.sqrt(half_chord_2 if half_chord_2 > _ZERO else _ZERO)
    along = x * ahead + y * left
    length = _first(along - half_chord, along + half_chord)
    return length if half_chord_2 >= _ZERO else _NEVER


@compiled_inline
def meets_side_m(
    x: Real, y: Real, side_ahead: Real, side_left: Real, ahead: Real, left: Real
) -> Real:
    """Length of the path up to the outer face of a side that begins at (x, y)."""
    facing = side_ahead * left - side_left * ahead
    along = ahead * y - left * x
    length = (side_ahead * y - side_left * x) / facing
    met = (facing > _ZERO) & (along >= -_LITTLE * facing) & (along <= _MORE * facing)
    met = met & (length >= _ZERO)
    return length if met else _NEVER


@compiled_inline
def reciprocal(component: Real, steepest: Real) -> Real:
    """1 / component, finite: components smaller than `steepest` are taken for it."""
    return np.float32(1.0) / math.copysign(max(abs(component), steepest), component)


@compiled_inline
def _first(enters: Real, leaves: Real) -> Real:
    length = enters if enters > _ZERO else _ZERO
    return length if length <= leaves else _NEVER
