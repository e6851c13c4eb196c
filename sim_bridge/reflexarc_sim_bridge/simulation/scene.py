"""Outlines of obstacles in the world's frame, for drawing and for tests."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.arrays.layout import (
    BOX,
    BOXES,
    DISC,
    DISCS,
    MAX_ROWS,
    SIDES,
    TURNED,
    TURNED_BOX,
    WALL,
    Params,
    Row,
    Table,
    WorldTables,
)
from reflexarc_sim_bridge.arrays.world_tables import world_tables
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.obstacles.chunks import DRAWN_DTYPE
from reflexarc_sim_bridge.obstacles.gathering import compiled_kind
from reflexarc_sim_bridge.obstacles.near_lists import displacement_m
from reflexarc_sim_bridge.obstacles.stripes import read_mark
from reflexarc_sim_bridge.simulation.stripe_outlines import Stripe, Striping, rgb_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.world import World

_SIGNS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], np.float64)
"""Corners of a box of half sides 1, counter-clockwise."""

_FEW = 64
"""Obstacles that few chunks have more of."""


@dataclass(frozen=True)
class Outline:
    """One obstacle: a disc, or a polygon with its corners counter-clockwise."""

    x_m: float
    """Centre; of a polygon the mean of its corners."""
    y_m: float
    radius_m: float
    """Of a disc; 0 for a polygon."""
    corners_m: npt.NDArray[np.float64]
    """(corners, 2); none for a disc."""
    is_box: bool
    """An upright rectangle."""
    colour: tuple[float, float, float]
    """Red, green, blue, 0 to 1."""
    layer: int
    stripes: tuple[Stripe, ...] = ()
    """Its pieces, each of a shade of its own, if it is striped; `colour` is then the middle of
    what they are drawn from."""

    @property
    def is_disc(self) -> bool:
        """Whether it is a disc."""
        return self.radius_m > 0.0


def outlines_of_chunk(world: World, seed: int, i: int, j: int) -> list[Outline]:
    """The obstacles of one chunk, where they are at the start.

    Args:
        world: the kind of world.
        seed: which world of that kind, 0 to 2⁶⁴ − 1.
        i: the chunk along x: it spans `CHUNK_M` from i · `CHUNK_M` on.
        j: the chunk along y.
    """
    prepare()
    tables = world_tables([world], PolicyContract())
    found = []
    for layer in range(len(world.layers)):
        striping = _striping(tables.planes[0], tables.layers[0, layer], layer, seed, 0.0)
        found += [_outline(row, layer, striping) for row in _drawn(tables, seed, layer, i, j)]
    return found


def outlines_near(params: Params, agent: int) -> list[Outline]:
    """The obstacles in the near lists of an agent, as its eye and its body meet them."""
    state, found = params.agents.state[agent], []
    plane = params.world.planes[state["world"]]
    sides_m = np.array([CHUNK_M, plane["chunk_width_m"]])
    for layer in range(int(plane["layers"])):
        row = params.world.layers[state["world"], layer]
        time_s = float(state["steps"] * plane["dt_s"])
        moved_m = _displacement_m(row, time_s)
        corner_m = params.agents.layer_cells[agent, layer] * sides_m + np.array(moved_m)
        striping = _striping(plane, row, layer, int(state["seed"]), time_s)
        found += _near_in_layer(params, agent, layer, corner_m, striping)
    return found


def _near_in_layer(
    params: Params,
    agent: int,
    layer: int,
    corner_m: npt.NDArray[np.float64],
    striping: Striping | None,
) -> list[Outline]:
    agents, counts = params.agents, params.agents.near_counts[agent, layer]
    boxes, found = agents.boxes[agent, layer, :, : counts[BOXES]].T.astype(float), []
    for x, y, length, width, *paint in boxes:
        corners = np.array([x, y]) + _SIGNS * (length, width) + corner_m
        found.append(_polygon(corners, BOX, paint[-1], layer, striping))
    turned = agents.turned[agent, layer, :, : counts[TURNED]].T.astype(float)
    for x, y, length, width, paint, cos, sin, *surface in turned:
        turn = np.array([(cos, sin), (-sin, cos)])
        corners = np.array([x, y]) + _SIGNS * (length, width) @ turn + corner_m
        found.append(_polygon(corners, TURNED_BOX, [paint, *surface][-1], layer, striping))
    for x, y, radius, *paint in agents.discs[agent, layer, :, : counts[DISCS]].T.astype(float):
        x_m, y_m = float(x + corner_m[0]), float(y + corner_m[1])
        found.append(_disc(x_m, y_m, float(radius), paint[-1], layer, striping))
    sides = agents.sides[agent, layer, :, : counts[SIDES]].T.astype(float)
    for polygon in _closed_polygons(sides):
        corners, paint = polygon[:, :2] + corner_m, polygon[0, 4]
        wall = paint if striping is None else _wall_of(paint)
        found.append(_polygon(corners, WALL, wall, layer, striping))
    return found


def _closed_polygons(sides: npt.NDArray[np.float64]) -> list[npt.NDArray[np.float64]]:
    """Sides in a row, cut where one closes its polygon."""
    polygons, first = [], 0
    for k in range(len(sides)):
        end_m = sides[k, :2] + sides[k, 2:4]
        if k > first + 1 and np.abs(end_m - sides[first, :2]).max() < 1e-4:
            polygons.append(sides[first : k + 1])
            first = k + 1
    return polygons


def _outline(row: Row, layer: int, striping: Striping | None) -> Outline:
    x_m, y_m, paint, corners = row["x_m"], row["y_m"], row["paint"], int(row["corners"])
    if row["kind"] == DISC:
        return _disc(x_m, y_m, float(row["radius_m"]), paint, layer, striping)
    corners_m = np.stack([row["corner_x_m"][:corners], row["corner_y_m"][:corners]], axis=1)
    return _polygon(corners_m, int(row["kind"]), paint, layer, striping)


def _disc(
    x_m: float, y_m: float, radius_m: float, paint: float, layer: int, striping: Striping | None
) -> Outline:
    """A disc; of a striped layer `paint` is its surface."""
    none = np.empty((0, 2))
    if striping is None:
        return Outline(x_m, y_m, radius_m, none, False, rgb_of(paint), layer)
    stripes = striping.of_disc(x_m, y_m, radius_m, int(paint))
    return Outline(x_m, y_m, radius_m, none, False, striping.middle_colour, layer, stripes)


def _polygon(
    corners_m: npt.NDArray[np.float64],
    kind: int,
    paint: float,
    layer: int,
    striping: Striping | None,
) -> Outline:
    """Anything else; of a striped layer `paint` is its surface."""
    x_m, y_m = corners_m.mean(axis=0).tolist()
    if striping is None:
        return Outline(x_m, y_m, 0.0, corners_m, kind == BOX, rgb_of(paint), layer)
    cut = striping.of_wall if kind == WALL else striping.of_box
    stripes, colour = cut(corners_m, int(paint)), striping.middle_colour
    return Outline(x_m, y_m, 0.0, corners_m, kind == BOX, colour, layer, stripes)


def _wall_of(mark: float) -> int:
    """Which wall of a corridor a mark in a near list stands for."""
    return int(_read_mark(np.float32(mark))[2])


@compiled
def _read_mark(mark: np.float32) -> tuple[int, int, int]:
    return read_mark(mark)


def _striping(plane: Row, row: Row, layer: int, seed: int, time_s: float) -> Striping | None:
    """The stripes of a layer at a time; None: it has none."""
    if row["stripes_m"] == 0.0:
        return None
    return Striping(row, layer, int(plane["stream"]), seed, time_s)


@compiled
def _displacement_m(layer: Row, time_s: float) -> tuple[float, float]:
    return displacement_m(layer, time_s)


def _drawn(tables: WorldTables, seed: int, number: int, i: int, j: int) -> Table:
    """The obstacles of a layer in a chunk: `DRAWN_DTYPE`: (n,)."""
    draw = compiled_kind(int(tables.layers[0, number]["kind"])).draw
    chunk, cells = (tables, np.uint64(seed), number, i, j), np.empty(MAX_ROWS, np.uint64)
    rows = np.zeros(_FEW, DRAWN_DTYPE)
    count = draw(*chunk, cells, rows)
    if count > len(rows):
        rows = np.zeros(count, DRAWN_DTYPE)
        draw(*chunk, cells, rows)
    return rows[:count]
