"""Lists of obstacles made too short on purpose."""

import numpy as np

from reflexarc_sim_bridge.simulation.simulation import Simulation


def shorten(simulation: Simulation, columns: int, *names: str) -> None:
    """Cut lists of all agents, and let what is near be listed anew at the next step.

    Args:
        simulation: whose.
        columns: how many are left, a multiple of 16.
        names: fields of `Agents`.
    """
    agents = simulation.params.agents
    shorter = {name: getattr(agents, name)[..., :columns].copy() for name in names}
    agents.near_counts[:] = np.minimum(agents.near_counts, 0)
    simulation.params = simulation.params._replace(agents=agents._replace(**shorter))
    simulation.params.agents.layer_cells[:] = 1 << 40
