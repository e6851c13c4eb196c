"""Arrays of a simulation: the world, the eye and the agents as compiled code reads and writes them.

Worlds are tables: one row a world (a single one, unless its numbers are drawn for each seed), one
a layer, one a shape. Everything that changes about an agent lies in its own row of `Agents`: the
work of one agent writes to that row and to nothing else, so the bits are the same on any number of
threads.

The plane is cut into chunks, which are also the cells in which an agent counts its place: a cell
(two integers) and an offset within it. An agent has lists of all obstacles that it could see or
meet from anywhere in its cell (its near lists), with places relative to the cell's corner in
float32: the same precision after a metre or a thousand kilometres. A list is a function of seed,
cell and time alone and is made anew when the agent enters another cell; a moving layer has cells of
its own.
"""

from collections.abc import Iterable
from typing import Any, NamedTuple, TypeAlias, get_type_hints

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.worlds.kinds.layer_kind import LayerKind

Table = npt.NDArray[np.void]
Floats32 = npt.NDArray[np.float32]
Integers32 = npt.NDArray[np.int32]
Row: TypeAlias = Any
"""A row of one of the tables here; compiled code reads its fields as attributes."""

PERIODIC, UNBOUNDED, OPEN = range(3)
AT_REST, DRIFT, SWING = range(3)
RESPAWN, GHOST, TERMINATE = range(3)
NOTHING, BOX, DISC, TURNED_BOX, POLYGON, CURVE, WALL = range(7)

# Rows of the near lists: one obstacle, or one side of one, a column.
BOX_X, BOX_Y, BOX_HALF_LENGTH, BOX_HALF_WIDTH, BOX_PAINT = range(5)
BOX_COS, BOX_SIN = 5, 6
PLACE_X, PLACE_Y = range(2)  # of a box, a disc or a side alike
DISC_X, DISC_Y, DISC_RADIUS, DISC_PAINT = range(4)
SIDE_X, SIDE_Y, SIDE_AHEAD, SIDE_LEFT, SIDE_PAINT = range(5)
BOX_ROWS, TURNED_ROWS, DISC_ROWS, SIDE_ROWS = 5, 7, 4, 5
MARK_LISTS, MARK_LAYERS = 4, 8
"""Marks of striped obstacles tell so many near lists and layers apart (`obstacles/stripes.py`)."""
BOXES, TURNED, DISCS, SIDES, BELT, FACES = range(6)
LIST_NAMES = "boxes", "turned boxes", "discs", "sides of polygons", "boxes on a belt", "faces"
"""Lists of limited length, in this order; the first four are the near lists."""

# Rows of a belt: all boxes of a periodic world within reach along x; COS and SIN of turned ones.
BELT_X, BELT_Y = range(2)
HALF_LENGTH, HALF_WIDTH, COS, SIN = range(4)

WHITE = 0xFFFFFF
"""Colour: 8 bits each of red, green and blue."""
TILE_RAYS = 16
"""Rays that are treated together."""
MAX_ROWS = 64
"""Rows of an automaton's chunk with its margins, rounded up."""

PLANE_DTYPE = np.dtype(
    [
        *((name, np.float64) for name in ("dt_s", "width_m", "chunk_width_m", "reach_m")),
        # How far ahead of an agent, behind and aside an obstacle can be seen or met.
        *((name, np.float64) for name in ("ahead_m", "behind_m", "aside_m")),
        *((name, np.float64) for name in ("radius_m", "slip", "follow")),
        *((name, np.float64) for name in ("most_linear_mps", "most_angular_radps")),
        *((name, np.float64) for name in ("noise", "dropout", "background")),
        # `across`: chunks from side to side, 0 where there are no sides.
        *((name, np.int64) for name in ("edges", "across", "stream", "layers", "corridor")),
        *((name, np.int64) for name in ("after_contact", "latency_steps", "gap_steps")),
    ],
    align=True,
)
"""One world: its plane, its agents' bodies and senses."""

_LAYER_COLUMNS: dict[str, type[np.generic]] = {
    **dict.fromkeys(("kind", "motion", "channels", "is_white"), np.int64),
    # Whether its near boxes are picked from a belt (`belt.py`): white boxes of one kind alone, even
    # and unthinned, where no near obstacle is farther to either side than half the period.
    "has_belt": np.int64,
    "reach_m": np.float64,
    # Drift: metres a second; swing: metres, and the period.
    **dict.fromkeys(("moves_ahead", "moves_left", "period_s"), np.float64),
    **{f"{c}_{end}": np.float64 for c in ("red", "green", "blue") for end in ("low", "high")},
    # Most of each near list: see `MostNear`.
    **dict.fromkeys(("most_boxes", "most_turned", "most_discs", "most_sides"), np.int64),
}
"""What every layer has, of whatever kind."""

SHAPE_DTYPE = np.dtype(
    [
        ("kind", np.int64),
        ("share_up_to", np.float64),
        *((name, np.float64) for name in ("size_low", "size_high", "length_low", "length_high")),
        *((name, np.float64) for name in ("turned_low", "turned_high")),
        *((name, np.float64) for name in ("dent_low", "dent_high")),
        *((name, np.int64) for name in ("corners_low", "corners_high")),
    ],
    align=True,
)
"""One kind of shape in a layer. `size` is a width (across) or a radius."""

AGENT_DTYPE = np.dtype(
    [
        *((name, np.int64) for name in ("world", "cell_x", "cell_y", "steps", "contacts")),
        ("seed", np.uint64),
        # Tells agents of one world apart: each has its own stream of random numbers.
        ("lane", np.uint64),
        ("draws", np.uint64),
        # Place within the cell, 0 to the side of a chunk.
        *((name, np.float64) for name in ("x_m", "y_m", "heading_rad", "distance_m")),
        *((name, np.float64) for name in ("linear_mps", "lateral_mps", "angular_radps")),
        ("looks", np.int64),
        # The step from which on a new retina comes.
        ("due", np.int64),
        ("is_inside", np.int64),
    ],
    align=True,
)
"""What changes about one agent."""


class WorldTables(NamedTuple):
    """Worlds as tables: row w of each is one world."""

    planes: Table
    """`PLANE_DTYPE`: (worlds,)."""
    layers: Table
    """As `layer_dtype` says: (worlds, layers)."""
    shapes: Table
    """`SHAPE_DTYPE`: (worlds, layers, shapes)."""
    counts: npt.NDArray[np.float64]
    """Probability that a chunk of a section has at most so many obstacles:
    (worlds, layers, sections, counts)."""
    belts: npt.NDArray[np.int64]
    """Columns of chunks that a belt of each layer may have, in any world that takes a row; 0 where
    none has one: (layers,)."""
    across: int
    """Chunks from side to side of the widest world that may take a row."""


class EyeParams(NamedTuple):
    """The eye of all agents. Arrays over the sub-rays of one eye, float32, the leftmost first.

    The last sub-ray is repeated until they fill whole tiles.
    """

    rays: int
    samples: int
    """Sub-rays of a ray."""
    blended: int
    """Sub-rays whose mean a ray shows: all of its own, or 1 where it shows the nearest of them."""
    eyes: int
    channels: int
    frames: int
    half_baseline_m: float
    range_m: float
    nearness: bool
    is_wide: bool
    """The rays span half a circle or more: every direction may matter."""
    tile_is_wide: bool
    """The same of the rays of one tile."""
    is_plain: bool
    """One grey eye, nothing blended, rays in whole tiles: the common case."""
    turns: bool
    """Whether agents can look elsewhere than along x."""
    ahead: Floats32
    """Direction of each sub-ray, x part (cosine of its bearing): (subrays,)."""
    left: Floats32
    """The same, y part (sine of its bearing)."""
    alive: npt.NDArray[np.bool_]
    """Whether a ray lies outside of all dead sectors: (rays,)."""


class Agents(NamedTuple):
    """Everything that changes, one row an agent."""

    state: Table
    """`AGENT_DTYPE`: (n,)."""
    layer_cells: npt.NDArray[np.int64]
    """Cell of the agent in each layer's own frame: (n, layers, 2)."""
    near_counts: npt.NDArray[np.int64]
    """Columns in use of the four lists below: (n, layers, 4)."""
    boxes: Floats32
    """Upright rectangles, rows BOX_X to BOX_PAINT: (n, layers, 5, capacity); in worlds with stripes
    this and the next two have one more row, for the surface (`obstacles/stripes.py`)."""
    turned: Floats32
    """Turned rectangles, all rows BOX_*: (n, layers, 7, capacity)."""
    discs: Floats32
    """Discs, rows DISC_*: (n, layers, 4, capacity)."""
    sides: Floats32
    """Sides of polygons, rows SIDE_*: (n, layers, 5, capacity)."""
    belt_places: Integers32
    """Belts, rows BELT_*: (n, layers, 2, capacity)."""
    belt_sizes: Floats32
    """The same, rows HALF_LENGTH to SIN: (n, layers, 4, capacity)."""
    belt_counts: npt.NDArray[np.int64]
    """Boxes in each column of a belt, the hindmost first: (n, layers, columns)."""
    delayed: npt.NDArray[np.uint8]
    """The last retinas, oldest first overwritten, for senses with latency:
    (n, latency_steps + 1, values)."""
    stack: npt.NDArray[np.uint8]
    """What the policy sees, oldest frame first: (n, frames · values)."""


class Near(NamedTuple):
    """The near lists of one agent in one layer: views of rows of `Agents`."""

    counts: npt.NDArray[np.int64]
    boxes: Floats32
    turned: Floats32
    discs: Floats32
    sides: Floats32


class Belt(NamedTuple):
    """The belt of one agent in one layer: views of rows of `Agents`."""

    places: Integers32
    sizes: Floats32
    counts: npt.NDArray[np.int64]


class Params(NamedTuple):
    """A simulation, as compiled code is given it."""

    world: WorldTables
    eye: EyeParams
    agents: Agents


def layer_dtype(kinds: Iterable[type[LayerKind]]) -> np.dtype[np.void]:
    """One layer: what every layer has, then the columns of each kind.

    Kinds may share a column of one name and type; a layer fills in those of its own kind.

    Raises:
        TypeError: a column of a kind has the name, but not the meaning or the type, of another.
    """
    columns = dict(_LAYER_COLUMNS)
    for kind in kinds:
        for name, form in get_type_hints(kind.COLUMNS).items():
            wanted = np.int64 if form is int else np.float64
            if name in _LAYER_COLUMNS or columns.setdefault(name, wanted) is not wanted:
                where = f"{kind.__name__}.COLUMNS: {name}"
                raise TypeError(f"{where}: expected a name that is not taken; choose another")
    return np.dtype(list(columns.items()), align=True)
