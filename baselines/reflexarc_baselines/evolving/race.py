"""What genomes cost: all of them in the same worlds at once, one agent a genome and world.

A body that moves sideways costs its contacts per 100 m of progress along x. For one that turns that
is no measure: contacts per second breed circling, and contacts per metre along x breed never
steering. It costs minus the greatest distance from its start before its first contact, in metres,
the mean over its worlds: a circle has a small one.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_baselines.evolving.genetics import Costs
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_runtime.policy.policy import RememberingPolicy
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named

_LEAST_M = 1e-6

Seeds = npt.NDArray[np.uint64]


def race(
    crowd: RememberingPolicy,
    contract: PolicyContract,
    world_name: str,
    genomes: int,
    seeds: Seeds,
    steps: int,
) -> Costs:
    """What each genome costs: (genomes,).

    Args:
        crowd: decides for genomes × worlds agents, the agents of a genome side by side.
        contract: what their bodies see, do and remember.
        world_name: where they live.
        genomes: how many.
        seeds: of the worlds, the same for all genomes.
        steps: in each world.
    """
    agents = genomes * len(seeds)
    simulation = Simulation(
        world_named(world_name),
        contract,
        np.tile(seeds, genomes),
        lanes=np.zeros(agents, np.uint64),  # all genomes start at the same places
    )
    turns = any(action.angular_radps != 0.0 for action in contract.actions)
    farthest = Farthest(agents, simulation.world.drawn(0).width_m) if turns else None
    _live(crowd, contract, simulation, steps, farthest)
    if farthest is not None:
        near: Costs = -farthest.distance_m.reshape(genomes, -1).mean(axis=1)
        return near
    contacts = simulation.contacts.reshape(genomes, -1).sum(axis=1)
    progress_m = simulation.distance_m.reshape(genomes, -1).sum(axis=1)
    costs: Costs = 100.0 * contacts / np.maximum(progress_m, _LEAST_M)
    return costs


class Farthest:
    """The greatest distance from the start before the first contact.

    Args:
        agents: how many.
        width_m: of the world: a place that jumps by more than half of it went over its seam.
    """

    def __init__(self, agents: int, width_m: float) -> None:
        self.distance_m = np.zeros(agents)
        """So far: (agents,)."""
        self._width_m = width_m
        self._has_met = np.zeros(agents, np.bool_)
        self._way_m = np.zeros((2, agents))
        self._before_m: npt.NDArray[np.float64] | None = None

    def see(self, x_m: npt.NDArray[np.float64], y_m: npt.NDArray[np.float64]) -> None:
        """The agents are here now: (agents,) each."""
        here_m = np.stack([x_m, y_m])
        if self._before_m is not None:
            moved_m = here_m - self._before_m
            moved_m[1] -= self._width_m * np.rint(moved_m[1] / self._width_m)
            self._way_m += moved_m
        self._before_m = here_m
        away_m = np.hypot(*self._way_m)
        self.distance_m = np.where(
            self._has_met, self.distance_m, np.maximum(self.distance_m, away_m)
        )

    def meet(self, met: npt.NDArray[np.bool_]) -> None:
        """Some of them have a contact: (agents,); where they are put then counts no more."""
        self._has_met |= met


def _live(
    crowd: RememberingPolicy,
    contract: PolicyContract,
    simulation: Simulation,
    steps: int,
    farthest: Farthest | None,
) -> None:
    start = start_of(contract, len(simulation))
    assert start is not None, "what evolves has a memory"
    memories = start.copy()
    for _ in range(steps):
        if farthest is not None:
            farthest.see(simulation.x_m, simulation.y_m)
        simulation.sense()
        _, actions, memories = crowd.decide(simulation.stacks, memories)
        met = simulation.step(actions)
        memories[met] = start[met]  # it was put to another place
        if farthest is not None:
            farthest.meet(met)
