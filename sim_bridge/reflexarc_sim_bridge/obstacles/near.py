"""What is near an agent: everything that it could see or meet from anywhere in its cell."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import AT_REST, DRIFT, SCATTER, Agents, Near, Params
from reflexarc_sim_bridge.arrays.parts import Parts
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled_inline, compiled_inner
from reflexarc_sim_bridge.native.function_pointers import call
from reflexarc_sim_bridge.obstacles.chunks import Row
from reflexarc_sim_bridge.worlds.layers import CHUNK_M

_NOWHERE = -(1 << 62)
"""The column of chunks of an agent that has not gathered yet."""


@compiled_inline
def displacement_m(layer: Row, time_s: float) -> tuple[float, float]:
    """How far a layer has moved: ahead, left."""
    if layer.motion == AT_REST:
        return 0.0, 0.0
    if layer.motion == DRIFT:
        return layer.moves_ahead * time_s, layer.moves_left * time_s
    share = math.sin(2.0 * math.pi * time_s / layer.period_s)
    return layer.moves_ahead * share, layer.moves_left * share


@compiled_inline
def place_in_layer_m(
    plane: Row, layer: Row, state: Row, cell: npt.NDArray[np.int64]
) -> tuple[float, float]:
    """Where an agent is in a layer's frame, from the corner of its cell (2,) there."""
    if layer.motion == AT_REST:
        return state.x_m, state.y_m
    moved_x_m, moved_y_m = displacement_m(layer, state.steps * plane.dt_s)
    x_m = state.x_m - moved_x_m + (state.cell_x - cell[0]) * CHUNK_M
    return x_m, state.y_m - moved_y_m + (state.cell_y - cell[1]) * plane.chunk_width_m


@compiled_inline
def forget_near(agents: Agents, i: int) -> None:
    """Let all that is near an agent be gathered anew."""
    for number in range(agents.layer_cells.shape[1]):
        agents.layer_cells[i, number, 0] = _NOWHERE


@compiled_inner
def keep_near(params: Params, work: Workspace, i: int) -> None:
    """Gather anew, layer by layer, where the agent has entered another cell."""
    world, agents = params.world, params.agents
    state = agents.state[i]
    plane = world.planes[state.world]
    for number in range(plane.layers):
        layer, cell = world.layers[state.world, number], agents.layer_cells[i, number]
        moved_x_m, moved_y_m = displacement_m(layer, state.steps * plane.dt_s)
        x, y = state.cell_x, state.cell_y
        if layer.motion != AT_REST:
            x += math.floor((state.x_m - moved_x_m) / CHUNK_M)
            y += math.floor((state.y_m - moved_y_m) / plane.chunk_width_m)
        if x != cell[0] or y != cell[1]:
            call(_gatherer(layer, work.parts), (params, work, i, number, x, y))


@compiled_inline
def _gatherer(layer: Row, parts: Parts) -> int:
    """Address of the function that lists what is near in such a layer."""
    if layer.has_belt:
        return parts.belt
    return parts.scatter if layer.kind == SCATTER else parts.structure


@compiled_inline
def near_of(agents: Agents, i: int, number: int) -> Near:
    """What is near agent i in a layer."""
    return Near(
        agents.near_counts[i, number],
        agents.boxes[i, number],
        agents.turned[i, number],
        agents.discs[i, number],
        agents.sides[i, number],
    )
