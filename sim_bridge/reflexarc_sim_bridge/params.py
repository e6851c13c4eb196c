"""The world, the eye and the agents as plain numbers and arrays: what compiled code is given.

Worlds are tables: one row a world (a single one, unless its numbers are drawn for each seed), one
a layer, one a shape. What an agent needs lies in its own row: one agent's work writes to that row
and to nothing else, so the bits are the same on any number of threads.

The plane is cut into chunks, which are also the cells in which an agent counts its place: a cell
(two integers) and an offset within it. Near an agent lies a list of all that it could see or meet
from anywhere in its cell, relative to the cell's corner in float32: the same precision after a
metre or a thousand kilometres. The list is a function of seed, cell and time alone and is gathered
anew when the agent enters another cell; a moving layer has cells of its own.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract, RetinaSpec, Shading
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.retina import nearest_beam, ray_bearing_rad
from reflexarc_sim_bridge.layers import (
    CHUNK_M,
    MAX_SECTIONS,
    Automaton,
    Corridor,
    Drift,
    Gates,
    Layer,
    Scatter,
    Swing,
)
from reflexarc_sim_bridge.outlines import CURVE_CORNERS
from reflexarc_sim_bridge.shapes import Curves, Discs, Polygons, Rectangles, Shape
from reflexarc_sim_bridge.worlds import AfterContact, Edges, Scanner, World

Table = npt.NDArray[np.void]
Floats32 = npt.NDArray[np.float32]

PERIODIC, UNBOUNDED, OPEN = range(3)
SCATTER, GATES, CORRIDOR, AUTOMATON = range(4)
AT_REST, DRIFT, SWING = range(3)
RESPAWN, GHOST, TERMINATE = range(3)
NOTHING, BOX, DISC, TURNED_BOX, POLYGON, CURVE, WALL = range(7)

# Rows of the near lists: one obstacle, or one side of one, a column.
BOX_X, BOX_Y, BOX_HALF_LENGTH, BOX_HALF_WIDTH, BOX_PAINT = range(5)
DISC_X, DISC_Y, DISC_RADIUS, DISC_PAINT = range(4)
SIDE_X, SIDE_Y, SIDE_AHEAD, SIDE_LEFT, SIDE_PAINT = range(5)
BOX_ROWS, DISC_ROWS, SIDE_ROWS = 5, 4, 5
BOXES, DISCS, SIDES = range(3)

TILE_RAYS = 16
"""Rays that are treated together."""

NOWHERE_M = (1e9, -2e9)
"""Where the last column of every near list is, whose obstacle has no size: beyond any range."""

_STEEPEST = 1e-9
"""Smaller direction components are taken for this: a finite slope, no division by zero."""
_SPARE_COLUMNS = 4
"""Rays take obstacles four at a time: the last four may be filled up with nothing."""

PLANE_DTYPE = np.dtype(
    [
        *((name, np.float64) for name in ("dt_s", "width_m", "chunk_width_m", "reach_m")),
        # How far ahead of an agent, behind and aside anything can be seen or met.
        *((name, np.float64) for name in ("ahead_m", "behind_m", "aside_m")),
        *((name, np.float64) for name in ("radius_m", "slip", "follow")),
        *((name, np.float64) for name in ("most_linear_mps", "most_angular_radps")),
        *((name, np.float64) for name in ("noise", "dropout", "background")),
        # `across`: chunks from side to side, 0 where there are no sides.
        *((name, np.int64) for name in ("edges", "across", "stream", "layers", "corridor")),
        *((name, np.int64) for name in ("after_contact", "latency_steps", "is_moving")),
    ],
    align=True,
)
"""One world: its plane, its agents' bodies and senses."""

LAYER_DTYPE = np.dtype(
    [
        *((name, np.int64) for name in ("kind", "shapes", "sections", "section_chunks", "motion")),
        *((name, np.float64) for name in ("reach_m", "gap_m")),
        # Drift: metres a second; swing: metres, and the period.
        *((name, np.float64) for name in ("moves_ahead", "moves_left", "period_s")),
        # `is_plain`: one kind of shape, none of them turned at random.
        # `is_upright_white`: nothing but upright white boxes, even and unthinned (the common case).
        ("is_upright_white", np.int64),
        *((name, np.int64) for name in ("is_plain", "is_white", "channels", "spacing_chunks")),
        *((f"{c}_{end}", np.float64) for c in ("red", "green", "blue") for end in ("low", "high")),
        *((name, np.float64) for name in ("pitch_m", "opening_low_m", "opening_high_m")),
        *((name, np.float64) for name in ("half_thickness_m", "half_width_m", "meander_m")),
        *((name, np.float64) for name in ("knot_m", "fill")),
        *((name, np.int64) for name in ("cells", "smoothings")),
    ],
    align=True,
)
"""One layer."""

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
        ("is_inside", np.int64),
    ],
    align=True,
)
"""What changes about one agent."""


class WorldTables(NamedTuple):
    """Worlds, compiled: row w is one world."""

    planes: Table
    """`PLANE_DTYPE`: (worlds,)."""
    layers: Table
    """`LAYER_DTYPE`: (worlds, layers)."""
    shapes: Table
    """`SHAPE_DTYPE`: (worlds, layers, shapes)."""
    counts: npt.NDArray[np.float64]
    """Probability that a chunk of a section has at most so many obstacles:
    (worlds, layers, sections, counts)."""
    most_chunks: int
    """Chunks within reach of an agent, at most."""


class EyeParams(NamedTuple):
    """The eye, compiled. Arrays over the sub-rays of one eye, float32, the leftmost first.

    The last sub-ray is repeated until they fill whole tiles.
    """

    rays: int
    samples: int
    """Sub-rays of a ray; it shows their mean."""
    eyes: int
    channels: int
    frames: int
    half_baseline_m: float
    range_m: float
    nearness: bool
    tile_is_wide: bool
    """The rays of a tile span half a circle or more: every direction may matter."""
    is_plain: bool
    """One grey eye, one frame, one sample, rays in whole tiles: the common case."""
    turns: bool
    """Whether agents can look elsewhere than along x."""
    ahead: Floats32
    """Direction of each sub-ray, x part (cosine of its bearing): (subrays,)."""
    left: Floats32
    """The same, y part (sine of its bearing)."""
    alive: npt.NDArray[np.bool_]
    """Whether a ray says anything: (rays,)."""


class Agents(NamedTuple):
    """Everything that changes, one row an agent."""

    state: Table
    """`AGENT_DTYPE`: (n,)."""
    layer_cells: npt.NDArray[np.int64]
    """Cell of the agent in each layer's own frame: (n, layers, 2)."""
    near_counts: npt.NDArray[np.int64]
    """Columns in use of the three lists below: (n, layers, 3)."""
    boxes: Floats32
    """Upright rectangles, rows BOX_*: (n, layers, 5, capacity)."""
    discs: Floats32
    """Discs, rows DISC_*: (n, layers, 4, capacity)."""
    sides: Floats32
    """Sides of polygons, rows SIDE_*: (n, layers, 5, capacity)."""
    delayed: npt.NDArray[np.uint8]
    """The last retinas, where seeing takes time: (n, latency + 1, values)."""
    stack: npt.NDArray[np.uint8]
    """What the policy sees, oldest frame first: (n, frames · values)."""


class Params(NamedTuple):
    """What compiled callers hand to `kernel`."""

    world: WorldTables
    eye: EyeParams
    agents: Agents


def world_tables(worlds: Sequence[World], contract: PolicyContract, densest: World) -> WorldTables:
    """Worlds of one structure for the agents that a contract describes.

    Args:
        worlds: one for all agents, or one for each.
        contract: what the agents see and do.
        densest: a world that needs as much room as any which may take a row later.

    Raises:
        WorldError: the worlds differ in their layers or shapes.
    """
    forms = {tuple(_shape_count(layer) for layer in world.layers) for world in worlds}
    if len(forms) != 1:
        raise WorldError("worlds: expected the same layers in every world of a family, got others")
    layers, shapes = max(1, len(worlds[0].layers)), max((*forms.pop(), 1))
    tables = WorldTables(
        np.zeros(len(worlds), PLANE_DTYPE),
        np.zeros((len(worlds), layers), LAYER_DTYPE),
        np.zeros((len(worlds), layers, shapes), SHAPE_DTYPE),
        np.ones((len(worlds), layers, MAX_SECTIONS, _most_counts((*worlds, densest)))),
        _most_chunks(densest, contract),
    )
    for w, world in enumerate(worlds):
        write_world(tables, w, world, contract)
    return tables


def write_world(tables: WorldTables, w: int, world: World, contract: PolicyContract) -> None:
    """Fill row `w` of the tables."""
    _write_plane(tables.planes[w : w + 1], world, contract)
    for number, layer in enumerate(world.layers):
        row = tables.layers[w, number : number + 1]
        # With open edges an obstacle may lie beside its chunk, pushed inwards.
        row["reach_m"] = layer.reach_m * (2 if world.edges is Edges.OPEN else 1)
        _write_colour(row, layer)
        _write_motion(row, layer)
        match layer:
            case Scatter():
                _write_scatter(row, layer)
                _write_shapes(tables.shapes[w, number], layer.shapes)
                chunk_m2 = CHUNK_M * chunk_width_m(world)
                row["is_upright_white"] = _is_upright_white(row, layer, world)
                tables.counts[w, number] = _cumulative_counts(layer, chunk_m2, tables.counts)
            case Gates():
                _write_gates(row, layer, world)
            case Corridor():
                _write_corridor(row, layer)
            case Automaton():
                row["kind"], row["cells"] = AUTOMATON, layer.cells_per_chunk
                row["fill"], row["smoothings"] = layer.fill, layer.smoothings


def eye_params(contract: PolicyContract, world: World) -> EyeParams:
    """The eyes of a contract, in a world.

    Behind a scanner a ray looks along the beam nearest to its bearing: what the runtime would take
    from the whole sweep, without casting the other beams.

    Raises:
        WorldError: the scanner does not cover the field of view.
    """
    spec = contract.retina
    bearings = _bearings(spec, spec.rays * spec.samples)
    if world.scanner is not None:
        bearings = [_beam_bearing_rad(bearing, world.scanner) for bearing in bearings]
    # The last tile is filled up with copies of the last ray.
    padding = -len(bearings) % TILE_RAYS
    tile_rad = max(
        bearings[first] - bearings[min(first + TILE_RAYS, len(bearings)) - 1]
        for first in range(0, len(bearings), TILE_RAYS)
    )
    return EyeParams(
        rays=spec.rays,
        samples=spec.samples,
        eyes=spec.eyes,
        channels=spec.channels,
        frames=spec.frames,
        half_baseline_m=spec.baseline_m / 2 if spec.eyes == 2 else 0.0,
        range_m=spec.range_m,
        nearness=spec.shading is Shading.NEARNESS,
        tile_is_wide=tile_rad > 0.99 * math.pi,
        is_plain=(spec.size, spec.frames, spec.samples) == (spec.rays, 1, 1)
        and spec.rays % TILE_RAYS == 0,
        turns=_turns(contract),
        ahead=np.cos(bearings + bearings[-1:] * padding).astype(np.float32),
        left=np.sin(bearings + bearings[-1:] * padding).astype(np.float32),
        alive=np.array([_is_alive(b, world) for b in _bearings(spec, spec.rays)], np.bool_),
    )


def agents_at_zero(
    seeds: npt.NDArray[np.uint64], world: World, tables: WorldTables, contract: PolicyContract
) -> Agents:
    """Agents that are nowhere yet; `kernel.place_all` puts them into their worlds.

    Args:
        seeds: one an agent: (n,).
        world: the densest of the worlds, which says how much room to make.
        tables: one world for all, or one for each agent.
        contract: what the agents see and do.
    """
    spec, n, layers = contract.retina, len(seeds), tables.layers.shape[1]
    state = np.zeros(n, AGENT_DTYPE)
    state["seed"], state["lane"] = seeds, _lanes(seeds)
    state["world"] = np.arange(n) if len(tables.planes) > 1 else 0
    boxes, discs, sides = _near_capacities(world_tables([world], contract, world))
    agents = Agents(
        state,
        np.zeros((n, layers, 2), np.int64),
        np.zeros((n, layers, 3), np.int64),
        np.zeros((n, layers, BOX_ROWS, boxes), np.float32),
        np.zeros((n, layers, DISC_ROWS, discs), np.float32),
        np.zeros((n, layers, SIDE_ROWS, sides), np.float32),
        np.zeros((n, world.senses.latency_steps + 1, spec.size), np.uint8),
        np.zeros((n, spec.frames * spec.size), np.uint8),
    )
    for near in (agents.boxes, agents.discs, agents.sides):
        near[:, :, 0, -1], near[:, :, 1, -1] = NOWHERE_M
    return agents


def chunk_width_m(world: World) -> float:
    """Side of a chunk across the world."""
    return CHUNK_M if world.edges is Edges.UNBOUNDED else world.width_m / _across(world)


def _across(world: World) -> int:
    return 0 if world.edges is Edges.UNBOUNDED else max(1, round(world.width_m / CHUNK_M))


def _write_plane(row: Table, world: World, contract: PolicyContract) -> None:
    chassis, senses = world.chassis, world.senses
    range_m = contract.retina.range_m + contract.retina.baseline_m / 2
    step_m = _fastest_mps(contract, world) * world.dt_s * (1 + 6 * chassis.slip) + chassis.radius_m
    behind_m = range_m if _turns(contract) else _behind_m(contract.retina)
    row["dt_s"], row["width_m"], row["chunk_width_m"] = (
        world.dt_s,
        world.width_m,
        chunk_width_m(world),
    )
    row["reach_m"] = world.reach_m
    row["ahead_m"], row["aside_m"] = max(range_m, step_m), max(range_m, step_m)
    row["behind_m"] = max(behind_m, step_m)
    row["radius_m"], row["slip"] = chassis.radius_m, chassis.slip
    row["follow"] = -math.expm1(-world.dt_s / chassis.lag_s) if chassis.lag_s > 0.0 else 1.0
    row["most_linear_mps"] = chassis.acceleration_mps2 * world.dt_s
    row["most_angular_radps"] = chassis.turn_acceleration_radps2 * world.dt_s
    row["noise"], row["dropout"] = senses.noise, senses.dropout
    row["background"], row["latency_steps"] = senses.background, senses.latency_steps
    row["edges"] = (PERIODIC, UNBOUNDED, OPEN)[
        (Edges.PERIODIC, Edges.UNBOUNDED, Edges.OPEN).index(world.edges)
    ]
    row["across"], row["stream"], row["layers"] = _across(world), world.stream, len(world.layers)
    row["corridor"] = world.layers.index(world.corridor) if world.corridor else -1
    row["after_contact"] = list(AfterContact).index(chassis.after_contact)
    row["is_moving"] = any(layer.motion is not None for layer in world.layers)


def _write_colour(row: Table, layer: Layer) -> None:
    spans = layer.colour * 3 if len(layer.colour) == 1 else layer.colour
    row["channels"] = len(layer.colour)
    row["is_white"] = all(span == (1.0, 1.0) for span in spans)
    for name, (low, high) in zip(("red", "green", "blue"), spans, strict=True):
        row[f"{name}_low"], row[f"{name}_high"] = low, high


def _write_motion(row: Table, layer: Layer) -> None:
    match layer.motion:
        case Drift(ahead_mps, left_mps):
            row["motion"], row["moves_ahead"], row["moves_left"] = DRIFT, ahead_mps, left_mps
        case Swing(ahead_m, left_m, period_s):
            row["motion"], row["moves_ahead"], row["moves_left"] = SWING, ahead_m, left_m
            row["period_s"] = period_s


def _write_scatter(row: Table, layer: Scatter) -> None:
    row["kind"], row["shapes"], row["gap_m"] = SCATTER, len(layer.shapes), layer.gap_m
    only = layer.shapes[0]
    upright = isinstance(only, Discs) or (isinstance(only, Rectangles) and not only.is_turned)
    row["is_plain"] = len(layer.shapes) == 1 and upright
    row["sections"] = max(1, len(layer.sections))
    row["section_chunks"] = max(1, round(layer.section_m / CHUNK_M))


def _is_upright_white(row: Table, layer: Scatter, world: World) -> bool:
    boxes = bool(row["is_plain"][0]) and isinstance(layer.shapes[0], Rectangles)
    even = layer.gap_m == 0.0 and not layer.sections and world.edges is not Edges.OPEN
    return boxes and even and bool(row["is_white"][0])


def _most_chunks(world: World, contract: PolicyContract) -> int:
    plane = np.zeros(1, PLANE_DTYPE)
    _write_plane(plane, world, contract)
    reach_m = 2 * world.reach_m
    length_m = float(CHUNK_M + plane["ahead_m"][0] + plane["behind_m"][0]) + reach_m
    width_m = float(plane["chunk_width_m"][0] + 2 * plane["aside_m"][0]) + reach_m
    across = float(plane["chunk_width_m"][0])
    return math.ceil(length_m / CHUNK_M + 1) * math.ceil(width_m / across + 1)


def _write_gates(row: Table, layer: Gates, world: World) -> None:
    row["kind"], row["spacing_chunks"] = GATES, max(1, round(layer.spacing_m / CHUNK_M))
    row["pitch_m"] = world.pitch_m(layer)
    row["opening_low_m"], row["opening_high_m"] = layer.opening_m
    row["half_thickness_m"] = layer.thickness_m / 2


def _write_corridor(row: Table, layer: Corridor) -> None:
    row["kind"], row["half_width_m"] = CORRIDOR, layer.width_m / 2
    row["meander_m"], row["knot_m"] = layer.meander_m, layer.wavelength_m / 2


def _write_shapes(rows: Table, shapes: Sequence[Shape]) -> None:
    total, up_to = math.fsum(shape.share for shape in shapes), 0.0
    for number, shape in enumerate(shapes):
        row = rows[number : number + 1]
        up_to += shape.share / total
        row["share_up_to"] = up_to
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


def _cumulative_counts(
    layer: Scatter, chunk_m2: float, counts: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Poisson: the probability of at most k obstacles in a chunk, of each section: (8, counts)."""
    factors = layer.sections or (1.0,)
    rows = np.ones((MAX_SECTIONS, counts.shape[3]))  # the last entry stays 1: nothing passes it
    for section, factor in enumerate(factors):
        mean, cumulative = layer.density_per_m2 * factor * chunk_m2, 0.0
        log_mean = math.log(mean) if mean > 0.0 else -math.inf
        for k in range(rows.shape[1] - 1):
            # By its logarithm: exp(−mean) alone is 0 in the densest chunks.
            cumulative += math.exp((k * log_mean if k else 0.0) - mean - math.lgamma(k + 1))
            rows[section, k] = min(cumulative, 1.0)
    return rows


def _most_counts(worlds: Sequence[World]) -> int:
    """Most obstacles that a chunk of any of the worlds can have."""
    means = [
        layer.density_per_m2 * max(layer.sections or (1.0,)) * CHUNK_M * chunk_width_m(world)
        for world in worlds
        for layer in world.layers
        if isinstance(layer, Scatter)
    ]
    return max((_poisson_quantile(mean) for mean in means), default=1)


def _poisson_quantile(mean: float) -> int:
    """The count that is passed with a probability below 1e-15; at least the mean."""
    probability = cumulative = math.exp(-mean)
    count = 0
    while cumulative < 1.0 - 1e-15 and count < mean + 12 * math.sqrt(mean) + 20:
        count += 1
        probability *= mean / count
        cumulative += probability
    return count + 1


def _near_capacities(tables: WorldTables) -> tuple[int, int, int]:
    """Columns of the three near lists: enough for any layer of any world."""
    needs = np.zeros(3, np.int64)
    for w, plane in enumerate(tables.planes):
        for number in range(int(plane["layers"])):
            needs = np.maximum(needs, _needs(tables, w, number))
    boxes, discs, sides = (int(need) + _SPARE_COLUMNS for need in needs)
    return boxes, discs, sides


def _needs(tables: WorldTables, w: int, number: int) -> npt.NDArray[np.int64]:
    """Most boxes, discs and sides near an agent: mean and ten standard deviations."""
    plane, layer = tables.planes[w], tables.layers[w, number]
    reach_m = 2 * layer["reach_m"]
    length_m = CHUNK_M + plane["ahead_m"] + plane["behind_m"] + reach_m
    width_m = plane["chunk_width_m"] + 2 * plane["aside_m"] + reach_m
    chunks = math.ceil(length_m / CHUNK_M + 1) * math.ceil(width_m / plane["chunk_width_m"] + 1)
    match int(layer["kind"]):
        case 1:  # gates: pieces of walls
            return np.array([4 * chunks, 0, 0])
        case 2:  # corridor: two walls of four sides
            return np.array([0, 0, 8 * math.ceil(length_m / CHUNK_M + 1)])
        case 3:  # automaton: every other cell at most begins a run
            return np.array([chunks * layer["cells"] * (layer["cells"] + 1) // 2, 0, 0])
    counts = tables.counts[w, number]
    densest = float((1.0 - counts).sum(axis=1).max()) / (CHUNK_M * plane["chunk_width_m"])
    mean = densest * _crowding(plane, layer) * length_m * width_m
    most = math.ceil(mean + 10 * math.sqrt(mean) + 20)
    corners = [_corners_of(shape) for shape in tables.shapes[w, number, : int(layer["shapes"])]]
    kinds = {int(shape["kind"]) for shape in tables.shapes[w, number, : int(layer["shapes"])]}
    return np.array([most * (BOX in kinds), most * (DISC in kinds), most * max(corners)])


def _crowding(plane: Any, layer: Any) -> float:
    """How much denser centres lie than they are drawn: with open edges, pushed inwards.

    More than fourfold they are in a strip that is narrower than what is near anyway.
    """
    if plane["edges"] != OPEN:
        return 1.0
    room_m = plane["width_m"] - layer["reach_m"]
    return float(plane["width_m"] / max(room_m, plane["width_m"] / 4))


def _corners_of(shape: Any) -> int:
    by_kind = {TURNED_BOX: 4, POLYGON: int(shape["corners_high"]), CURVE: CURVE_CORNERS}
    return by_kind.get(int(shape["kind"]), 0)


def _shape_count(layer: Layer) -> int:
    return len(layer.shapes) if isinstance(layer, Scatter) else 0


def _bearings(spec: RetinaSpec, rays: int) -> list[float]:
    return [ray_bearing_rad(ray, rays, spec.fov_rad) for ray in range(rays)]


def _beam_bearing_rad(bearing_rad: float, scanner: Scanner) -> float:
    beam = nearest_beam(bearing_rad, scanner.start_rad, scanner.step_rad)
    if beam >= scanner.beams:
        raise WorldError(
            f"world.scanner: a sweep of {scanner.sweep_rad:.3f} rad has no beam at "
            f"{bearing_rad:.3f} rad; expected one that covers the field of view"
        )
    return scanner.start_rad + beam * scanner.step_rad


def _is_alive(bearing_rad: float, world: World) -> bool:
    return not any(low <= bearing_rad <= high for low, high in world.senses.dead_sectors)


def _fastest_mps(contract: PolicyContract, world: World) -> float:
    own = max(math.hypot(a.linear_mps, a.lateral_mps) for a in contract.actions)
    return own + max((_layer_speed_mps(layer) for layer in world.layers), default=0.0)


def _layer_speed_mps(layer: Layer) -> float:
    match layer.motion:
        case Drift(ahead_mps, left_mps):
            return math.hypot(ahead_mps, left_mps)
        case Swing(ahead_m, left_m, period_s):
            return math.tau / period_s * math.hypot(ahead_m, left_m)
    return 0.0


def _turns(contract: PolicyContract) -> bool:
    return any(action.angular_radps != 0.0 for action in contract.actions)


def _behind_m(spec: RetinaSpec) -> float:
    """A ray at bearing φ reaches range · (−cos φ) behind; within ±90° none does."""
    outermost_rad = ray_bearing_rad(0, spec.rays * spec.samples, spec.fov_rad)
    return spec.range_m * max(0.0, -math.cos(outermost_rad))


def _lanes(seeds: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """How many earlier agents have the same seed: (n,)."""
    seen: dict[int, int] = {}
    lanes = np.zeros(len(seeds), np.uint64)
    for i, seed in enumerate(seeds.tolist()):
        lanes[i] = seen.setdefault(seed, 0)
        seen[seed] += 1
    return lanes
