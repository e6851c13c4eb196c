"""Which places of a world an agent could not stand at, because an obstacle is there."""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.simulation.step import call_cover
from reflexarc_sim_bridge.simulation.step_compilation import cover_for
from reflexarc_sim_bridge.worlds.world import World


def covered(
    world: World, contract: PolicyContract, seed: int, places_m: npt.NDArray[np.float64]
) -> npt.NDArray[np.bool_]:
    """Whether the body of an agent would cover or touch an obstacle, at the start.

    Args:
        world: which world.
        contract: whose agent.
        seed: which of the world's variants.
        places_m: x and y: (n, 2).

    Returns:
        (n,)
    """
    simulation = Simulation(world, contract, np.array([seed], np.uint64))
    found = np.empty(len(places_m), np.bool_)
    at = cover_for(simulation.params, motions_of(contract))
    held = simulation.held_step()[1]
    call_cover(at, held, np.ascontiguousarray(places_m, np.float64), found)
    simulation.require_nothing_lost(held)
    return found
