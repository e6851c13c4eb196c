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
        found += [_outline(row, layer) for row in _drawn(tables, seed, layer, i, j)]
    return found


def outlines_near(params: Params, agent: int) -> list[Outline]:
    """The obstacles in the near lists of an agent, as its eye and its body meet them."""
    state, found = params.agents.state[agent], []
    plane = params.world.planes[state["world"]]
    sides_m = np.array([CHUNK_M, plane["chunk_width_m"]])
    for layer in range(int(plane["layers"])):
        row = params.world.layers[state["world"], layer]
        moved_m = _displacement_m(row, float(state["steps"] * plane["dt_s"]))
        corner_m = params.agents.layer_cells[agent, layer] * sides_m + np.array(moved_m)
        found += _near_in_layer(params, agent, layer, corner_m)
    return found


def _near_in_layer(
    params: Params, agent: int, layer: int, corner_m: npt.NDArray[np.float64]
) -> list[Outline]:
    agents, counts = params.agents, params.agents.near_counts[agent, layer]
    found = []
    for x, y, length, width, paint in agents.boxes[agent, layer, :, : counts[BOXES]].T.astype(
        float
    ):
        corners = np.array([x, y]) + _SIGNS * (length, width) + corner_m
        found.append(_polygon(corners, True, paint, layer))
    turned = agents.turned[agent, layer, :, : counts[TURNED]].T.astype(float)
    for x, y, length, width, paint, cos, sin in turned:
        turn = np.array([(cos, sin), (-sin, cos)])
        corners = np.array([x, y]) + _SIGNS * (length, width) @ turn + corner_m
        found.append(_polygon(corners, False, paint, layer))
    for x, y, radius, paint in agents.discs[agent, layer, :, : counts[DISCS]].T.astype(float):
        x_m, y_m = float(x + corner_m[0]), float(y + corner_m[1])
        none = np.empty((0, 2))
        found.append(Outline(x_m, y_m, float(radius), none, False, _colour(paint), layer))
    sides = agents.sides[agent, layer, :, : counts[SIDES]].T.astype(float)
    return found + [
        _polygon(polygon[:, :2] + corner_m, False, polygon[0, 4], layer)
        for polygon in _closed_polygons(sides)
    ]


def _closed_polygons(sides: npt.NDArray[np.float64]) -> list[npt.NDArray[np.float64]]:
    """Sides in a row, cut where one closes its polygon."""
    polygons, first = [], 0
    for k in range(len(sides)):
        end_m = sides[k, :2] + sides[k, 2:4]
        if k > first + 1 and np.abs(end_m - sides[first, :2]).max() < 1e-4:
            polygons.append(sides[first : k + 1])
            first = k + 1
    return polygons


def _outline(row: Row, layer: int) -> Outline:
    x_m, y_m, paint, corners = row["x_m"], row["y_m"], row["paint"], int(row["corners"])
    if row["kind"] == DISC:
        none = np.empty((0, 2))
        return Outline(x_m, y_m, float(row["radius_m"]), none, False, _colour(paint), layer)
    corners_m = np.stack([row["corner_x_m"][:corners], row["corner_y_m"][:corners]], axis=1)
    return _polygon(corners_m, row["kind"] == BOX, paint, layer)


def _polygon(corners_m: npt.NDArray[np.float64], is_box: bool, paint: float, layer: int) -> Outline:
    x_m, y_m = corners_m.mean(axis=0).tolist()
    return Outline(x_m, y_m, 0.0, corners_m, is_box, _colour(paint), layer)


def _colour(paint: float) -> tuple[float, float, float]:
    bits = int(paint)
    return (bits >> 16) / 255, (bits >> 8 & 255) / 255, (bits & 255) / 255


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
