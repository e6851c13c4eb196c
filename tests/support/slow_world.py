"""Every obstacle around an agent, from the chunks and not from what the simulator keeps near."""

import math

from reflexarc_sim_bridge.chunks import obstacles_of_chunk
from reflexarc_sim_bridge.params import CHUNK_M
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import Edges
from support.slow_geometry import Obstacle


def obstacles_around(simulation: Simulation, agent: int, chunks: int = 3) -> list[Obstacle]:
    """Obstacles of some chunks before and behind an agent, in its own and both next periods."""
    world, here = simulation.world, math.floor(simulation.x_m[agent] / CHUNK_M)
    seed = int(simulation.params.agents.seed[agent])
    periods = (-1, 0, 1) if world.edges is Edges.PERIODIC else (0,)
    scene = []
    for chunk in range(here - chunks, here + chunks + 1):
        for row in obstacles_of_chunk(world, seed, chunk):
            x_m, y_m, length, width, disc, _ = row.item()
            scene += [Obstacle(x_m, y_m + k * world.width_m, length, width, disc) for k in periods]
    return scene
