"""Obstacles that had no room in a list: an error, raised after the step that lost them.

Compiled code counts them (`Losses`) and goes on; its caller in Python checks the counts here.
"""

import numpy as np

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.layout import BELT, FACES, LIST_NAMES, Params
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.intrinsics import LANES


def require_nothing_lost(world: str, params: Params, work: Workspace) -> None:
    """Raise if a list was full since this was last asked of the workspace.

    Args:
        world: name of the world.
        params: the simulation.
        work: scratch of the thread that was at work.

    Raises:
        WorldError: an obstacle had no room in a list, so that it could not be seen or met.
    """
    losses = work.losses
    if np.count_nonzero(losses.counts) == 0:  # quicker than `any`
        return
    kind = int(losses.counts.argmax())
    lost, agent = int(losses.counts[kind]), int(losses.agents[kind])
    losses.counts[:] = 0
    raise WorldError(
        f"world {world!r}, seed {params.agents.state['seed'][agent]}: expected room for all "
        f"{LIST_NAMES[kind]} near an agent, got {lost} more than the {_room(params, work, kind)} "
        "that fit; they were not seen or met, so do not use what was computed, and report this "
        "line: a list must be made longer"
    )


def _room(params: Params, work: Workspace, kind: int) -> int:
    """How many entries a list has room for."""
    agents = params.agents
    if kind == BELT:
        return int(agents.belt_places.shape[3])
    if kind == FACES:
        return len(work.faces.paint) - LANES
    near = agents.boxes, agents.turned, agents.discs, agents.sides
    return int(near[kind].shape[3]) - LANES
