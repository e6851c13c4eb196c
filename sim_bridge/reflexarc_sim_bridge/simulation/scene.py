"""Obstacles for drawing and for tests: outlines in the world's frame."""

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract
from reflexarc_sim_bridge.arrays.layout import (
    BOX,
    BOXES,
    DISC,
    DISCS,
    MAX_ROWS,
    NOTHING,
    SCATTER,
    SIDES,
    TURNED,
    Params,
    Row,
    WorldTables,
)
from reflexarc_sim_bridge.arrays.world_tables import world_tables
from reflexarc_sim_bridge.native.decorators import compiled, compiled_allocating
from reflexarc_sim_bridge.obstacles import chunks
from reflexarc_sim_bridge.obstacles.keys import chunk_key, column_key, layer_key
from reflexarc_sim_bridge.obstacles.near_lists import displacement_m
from reflexarc_sim_bridge.obstacles.structures import structure_at, structure_count
from reflexarc_sim_bridge.worlds.layers import CHUNK_M
from reflexarc_sim_bridge.worlds.world import World

_SIGNS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], np.float64)
"""Corners of a box of half sides 1, counter-clockwise."""

_MAX_CORNERS = 32
_ROW = 8 + 2 * _MAX_CORNERS


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
    tables = world_tables([world], PolicyContract())
    found = []
    for layer in range(len(world.layers)):
        rows = _listed(tables, np.uint64(seed), layer, i, j)
        found += [_outline(row, layer) for row in rows]
    return found


def outlines_near(params: Params, agent: int) -> list[Outline]:
    """What is near an agent, as its eye and its body meet it."""
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


def _outline(row: npt.NDArray[np.float64], layer: int) -> Outline:
    kind, x_m, y_m, radius_m, count, paint = row[:6]
    if kind == DISC:
        none = np.empty((0, 2))
        return Outline(x_m, y_m, float(radius_m), none, False, _colour(paint), layer)
    corners_m = row[8 : 8 + 2 * int(count)].reshape(-1, 2)
    return _polygon(corners_m, kind == BOX, paint, layer)


def _polygon(corners_m: npt.NDArray[np.float64], is_box: bool, paint: float, layer: int) -> Outline:
    x_m, y_m = corners_m.mean(axis=0).tolist()
    return Outline(x_m, y_m, 0.0, corners_m, is_box, _colour(paint), layer)


def _colour(paint: float) -> tuple[float, float, float]:
    bits = int(paint)
    return (bits >> 16) / 255, (bits >> 8 & 255) / 255, (bits & 255) / 255


@compiled
def _displacement_m(layer: Row, time_s: float) -> tuple[float, float]:
    return displacement_m(layer, time_s)


@compiled_allocating
def _listed(
    world: WorldTables, seed: np.uint64, number: int, i: int, j: int
) -> npt.NDArray[np.float64]:
    """A chunk's obstacles as rows: kind, x, y, radius, corners, paint, two spare, corners."""
    plane, layer, cells = world.planes[0], world.layers[0, number], np.empty(MAX_ROWS, np.uint64)
    shapes, counts = world.shapes[0, number], world.counts[0, number]
    key = layer_key(plane.stream, seed, number)
    chunk = chunk_key(column_key(key, i), j, plane.across)
    if layer.kind == SCATTER:
        count = chunks.scatter_count(layer, counts, chunk, i)
    else:
        count = structure_count(plane, layer, key, i, j, cells)
    rows, n = np.zeros((count, _ROW)), 0
    for index in range(count):
        if layer.kind != SCATTER:
            obstacle = structure_at(plane, layer, key, i, j, index, cells)
        else:
            obstacle = chunks.scattered(plane, layer, shapes, chunk, j, index)
            if layer.gap_m > 0.0 and chunks.is_thinned(plane, layer, counts, key, i, j, index):
                continue
        if obstacle.kind == NOTHING:
            continue
        x_m = obstacle.x_m + i * CHUNK_M
        y_m = obstacle.y_m + j * plane.chunk_width_m
        corners = chunks.corner_count(obstacle)
        rows[n, 0], rows[n, 1], rows[n, 2] = obstacle.kind, x_m, y_m
        rows[n, 3], rows[n, 4], rows[n, 5] = obstacle.half_length_m, corners, obstacle.paint
        cos, sin = math.cos(obstacle.turned_rad), math.sin(obstacle.turned_rad)
        for corner in range(corners):
            dx_m, dy_m = chunks.corner_m(chunk, obstacle, corner, cos, sin)
            rows[n, 8 + 2 * corner], rows[n, 9 + 2 * corner] = x_m + dx_m, y_m + dy_m
        n += 1
    return rows[:n]
