"""Keeping an agent's near lists: they are made anew when it enters another cell.

Each kind of layer has its own gather function, called by address (`Parts`) and compiled apart: a
world of boxes need not compile the code of corridors, and an agent enters
another cell once in ten steps or more.
"""

import math
from importlib import import_module
from types import ModuleType
from typing import Any

from reflexarc_sim_bridge.arrays.layout import AT_REST, Params, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled_inner
from reflexarc_sim_bridge.native.function_pointers import at_address, call
from reflexarc_sim_bridge.obstacles.near_lists import displacement_m, near_of
from reflexarc_sim_bridge.obstacles.stripes import mark_surfaces
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.layers import layer_kinds

_ROOMS = ".worlds.kinds.", ".obstacles.kinds."


@compiled_inner
def keep_near(params: Params, work: Workspace, i: int) -> None:
    """Make the near lists of an agent anew in those layers where it has entered another cell."""
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
            table = work.parts.gatherers
            gatherer = at_address(table.nowhere, table.addresses[layer.kind, layer.has_belt])
            call(gatherer, (params, work, i, number, x, y))
            if layer.stripes_m > 0.0:
                mark_surfaces(near_of(agents, i, number), number)


def compiled_kind(number: int) -> ModuleType:
    """The module that draws and gathers the layers of a kind, by the kind's number.

    It is the namesake of the kind's own, in `obstacles/kinds` instead of `worlds/kinds`.
    """
    return import_module(layer_kinds()[number].__module__.replace(*_ROOMS))


def gatherers_for(world: WorldTables, is_family: bool) -> dict[tuple[int, int], Any]:
    """The functions that fill the near lists of a world's layers, by (kind, whether it has a belt).

    In a family a layer that may have a belt has one in some worlds and none in others.

    Args:
        world: the tables.
        is_family: whether other worlds may take their rows later.
    """
    needed = set(zip(world.layers["kind"].flat, world.layers["has_belt"].flat, strict=True))
    if is_family:
        kinds, may_have_belt = world.layers["kind"][0], world.belts > 0
        needed |= {(kind, 0) for kind in kinds} | {(kind, 1) for kind in kinds[may_have_belt]}
    return {(int(kind), int(belt)): _gatherer(kind, belt) for kind, belt in sorted(needed)}


def _gatherer(kind: int, has_belt: int) -> Any:
    module = compiled_kind(kind)
    return module.gather_belt if has_belt else module.gather
