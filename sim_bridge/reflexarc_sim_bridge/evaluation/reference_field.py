"""The reference field: one fixed world and one way to measure, so that figures can be compared.

World `reference-1` (in `shipped/`), the reference eye, forward and sideways speed 1 m/s,
steps of 0.1 s. A policy is greedy and decides at every step. 4,096 agents, each in the world of a
test seed; 100 steps are discarded, then 2,000 are counted. The figure is contacts per 100 m of
progress along x, with a 95 % bootstrap interval over agents.

Progress along x, not the length of the path: zigzagging does not improve the score. An agent that
never steers scores 100 · 2ρR = 36.0.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.evaluation.pilot import Pilot
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import WorldSource

if TYPE_CHECKING:
    from reflexarc_runtime.policy.policy import Policy, RememberingPolicy

AGENTS = 4096
STEPS = 2000
DISCARDED_STEPS = 100

_RESAMPLES = 1000
_BOOTSTRAP_SEED = 20_250_101


@dataclass(frozen=True)
class FieldScore:
    """The score of a policy, with the 95 % interval of a bootstrap over agents."""

    contacts_per_100m: float
    low: float
    high: float
    distance_m: float
    """Progress of all agents together."""
    contacts: int
    agents: int


def measure(
    policy: "Policy | RememberingPolicy",
    contract: PolicyContract,
    *,
    agents: int = AGENTS,
    steps: int = STEPS,
    discard: int = DISCARDED_STEPS,
    seeds: npt.NDArray[np.uint64] | None = None,
    world: WorldSource | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FieldScore:
    """Measure a policy: contacts per 100 m, with its interval.

    Args:
        policy: decides for all agents at once.
        contract: its eye and its actions. An eye other than the reference's sees the same world.
        agents: number of agents.
        steps: counted steps of each agent.
        discard: steps of each before the counting begins.
        seeds: worlds of the agents, cycled if there are fewer than agents; test seeds if None.
        world: another kind of world than the reference's.
        progress: called after each step with the steps done and the steps in all.

    Raises:
        WorldError: a contract that the simulator does not support.
    """
    seeds = test_seeds(agents) if seeds is None else np.resize(seeds, agents)
    simulation = Simulation(world or world_named(WORLD_NAME), contract, seeds)
    pilot = Pilot(policy, contract, agents, simulation.dt_s)
    before = (simulation.distance_m.copy(), simulation.contacts.copy())
    for step in range(discard + steps):
        if step == discard:
            before = (simulation.distance_m.copy(), simulation.contacts.copy())
        simulation.sense()
        simulation.step(pilot.act(simulation.stacks))
        if progress is not None:
            progress(step + 1, discard + steps)
    return _score(simulation.distance_m - before[0], simulation.contacts - before[1])


def _score(distance_m: npt.NDArray[np.float64], contacts: npt.NDArray[np.int64]) -> FieldScore:
    low, high = _bootstrap_interval(distance_m, contacts)
    return FieldScore(
        contacts_per_100m=100.0 * float(contacts.sum() / distance_m.sum()),
        low=low,
        high=high,
        distance_m=float(distance_m.sum()),
        contacts=int(contacts.sum()),
        agents=len(contacts),
    )


def _bootstrap_interval(
    distance_m: npt.NDArray[np.float64], contacts: npt.NDArray[np.int64]
) -> tuple[float, float]:
    """95 % percentile interval of the ratio of sums, agents drawn with replacement."""
    generator = np.random.default_rng(_BOOTSTRAP_SEED)
    n, rates = len(contacts), np.empty(_RESAMPLES)
    for i in range(_RESAMPLES):
        drawn = generator.integers(0, n, n)
        rates[i] = 100.0 * contacts[drawn].sum() / distance_m[drawn].sum()
    low, high = np.percentile(rates, (2.5, 97.5))
    return float(low), float(high)
