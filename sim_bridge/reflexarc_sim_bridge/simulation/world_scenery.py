"""The obstacles of a simulated world, anywhere and at any time.

A world is a grid of chunks, and the grid of a moving layer moves. So the obstacles in an area are
those of the chunks under it, after the area is shifted back by as much as the layer has moved.
"""

import math
from collections.abc import Iterator

from reflexarc_sim_bridge.simulation.scene import Outline, outlines_of_chunk
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import CHUNK_M
from reflexarc_sim_bridge.worlds.silhouettes import (
    Area,
    Silhouette,
    circle,
    moved_m,
    on_pale_ground,
    reaches_into,
)
from reflexarc_sim_bridge.worlds.world import Edges


class WorldScenery:
    """The obstacles of the world of a simulation's first agent."""

    def __init__(self, simulation: Simulation) -> None:
        tables, state = simulation.params.world, simulation.params.agents.state[0]
        self._seed = int(state["seed"])
        self._world = simulation.world.drawn(self._seed)
        self._side_m = float(tables.planes[state["world"]]["chunk_width_m"])
        self._chunks: dict[tuple[int, int], list[Outline]] = {}

    def within(self, area: Area, time_s: float) -> list[Silhouette]:
        """The obstacles that reach into an area at a time of the world (s)."""
        found = []
        for number, layer in enumerate(self._world.layers):
            now, before = moved_m(layer.motion, time_s), moved_m(layer.motion, time_s - 1.0)
            wake_m = (now[0] - before[0], now[1] - before[1])
            for outline in self._listed(number, _around(area, now, layer.reach_m)):
                silhouettes = _silhouettes(outline, now, wake_m)
                found += [s for s in silhouettes if reaches_into(s.corners_m, area)]
        return found

    def _listed(self, layer: int, area: Area) -> Iterator[Outline]:
        """The obstacles of a layer in the chunks of an area, in the frame of the layer."""
        for i in _chunks(area.low_x_m, area.high_x_m, CHUNK_M):
            for j in _chunks(area.low_y_m, area.high_y_m, self._side_m):
                yield from (outline for outline in self._chunk(i, j) if outline.layer == layer)

    def _chunk(self, i: int, j: int) -> list[Outline]:
        is_outside = self._world.edges is Edges.OPEN and not (
            0 <= (j + 0.5) * self._side_m < self._world.width_m
        )
        if (i, j) not in self._chunks:
            listed = [] if is_outside else outlines_of_chunk(self._world, self._seed, i, j)
            self._chunks[i, j] = listed
        return self._chunks[i, j]


def _around(area: Area, way_m: tuple[float, float], reach_m: float) -> Area:
    """The area, in a layer's frame, in which obstacles have their centres if they reach into it."""
    (x_m, y_m), (low_x, high_x, low_y, high_y) = way_m, area
    return Area(
        low_x - x_m - reach_m, high_x - x_m + reach_m, low_y - y_m - reach_m, high_y - y_m + reach_m
    )


def _chunks(low_m: float, high_m: float, side_m: float) -> range:
    return range(math.floor(low_m / side_m), math.floor(high_m / side_m) + 1)


def _silhouettes(
    outline: Outline, way_m: tuple[float, float], wake_m: tuple[float, float]
) -> list[Silhouette]:
    """An obstacle seen from above, or the stripes of a striped one."""
    if outline.stripes:
        pieces = [(stripe.corners_m, stripe.colour) for stripe in outline.stripes]
        return [Silhouette(at + way_m, on_pale_ground(rgb), wake_m) for at, rgb in pieces]
    corners_m = outline.corners_m
    if outline.is_disc:
        corners_m = circle(outline.x_m, outline.y_m, outline.radius_m)
    return [Silhouette(corners_m + way_m, on_pale_ground(outline.colour), wake_m)]
