"""Puts the only agent of a simulation somewhere, at some time of its world."""

import math
from typing import Any

import numpy as np

from reflexarc_sim_bridge.arrays.layout import OPEN, PERIODIC
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

_NOWHERE = -(1 << 62)
"""No cell has this number: all near lists are made anew at the next step."""


def put_at(agent: Simulation, x_m: float, y_m: float, heading_rad: float, steps: int) -> None:
    """Put the first agent at a place, as if it had come there.

    It keeps its speeds, its contacts, what it saw, and its stream of random numbers.

    Args:
        agent: a simulation.
        x_m: place ahead.
        y_m: place to the left; within the sides of a world that has any.
        heading_rad: where it looks, counter-clockwise from x.
        steps: how many its world has made: where what moves in it is.
    """
    here = agent.params.agents.state[0].copy()
    plane = agent.params.world.planes[here["world"]]
    side_m = float(plane["chunk_width_m"])
    if plane["edges"] == OPEN:
        y_m = min(max(y_m, 0.0), float(plane["width_m"]))
    cell_x, cell_y = math.floor(x_m / CHUNK_M), math.floor(y_m / side_m)
    here["cell_x"], here["x_m"] = cell_x, x_m - cell_x * CHUNK_M
    here["cell_y"], here["y_m"] = cell_y, y_m - cell_y * side_m
    if plane["edges"] == PERIODIC:
        here["cell_y"] = cell_y % int(plane["across"])
    here["heading_rad"], here["steps"] = heading_rad, steps
    settle(agent, here)


def settle(agent: Simulation, here: Any) -> None:
    """Let the first agent have a state, and list what is near it there.

    Args:
        agent: a simulation.
        here: a row of `AGENT_DTYPE`.
    """
    agents = agent.params.agents
    agents.layer_cells[0], agents.near_counts[0] = _NOWHERE, 0
    # A step on the spot, among nothing, lists what is near; it is undone but for that.
    agents.state[0] = here
    for speed in ("linear_mps", "lateral_mps", "angular_radps"):
        agents.state[speed][0] = 0.0
    agents.state["steps"][0] -= 1
    agent.drive(0.0, 0.0, 0.0)
    agents.state[0] = np.asarray(here)
