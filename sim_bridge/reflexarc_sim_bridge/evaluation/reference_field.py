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
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_sim_bridge.evaluation.driving.crowd_guard import CrowdGuard, Interventions
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.protocol.foreign_code import foreign_code
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
LEAST_M = 1e-6
"""Agents that all stand have no rate; this one keeps it a number."""

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
    guarded: float = 0.0
    """Share of the decisions that a guard replaced, the discarded steps among them."""
    stuck: float = 0.0
    """Share of the decisions at which it let the agent stand."""


def measure(
    policy: "Policy | RememberingPolicy",
    contract: PolicyContract,
    *,
    agents: int = AGENTS,
    steps: int = STEPS,
    discard: int = DISCARDED_STEPS,
    seeds: npt.NDArray[np.uint64] | None = None,
    world: WorldSource | None = None,
    guard: GuardSettings | None = None,
    progress: Callable[[int, int], None] | None = None,
    name: str = "the policy",
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
        guard: settings of the guard behind which they drive; None: without one.
        progress: called after each step with the steps done and the steps in all.
        name: how complaints name the policy.

    Raises:
        UsageError: what cannot be measured: no policy, no contract, no agents, no steps or no
            seeds; or the policy raised something, or decided for others than it was asked.
        WorldError: a contract that the simulator does not support.
    """
    _check(policy, contract, agents, steps, discard, seeds)
    seeds = test_seeds(agents) if seeds is None else np.resize(seeds, agents)
    field = world or world_named(WORLD_NAME)
    crowd = None if guard is None else CrowdGuard(guard, contract, field.drawn(0).dt_s)
    simulation = Simulation(field, contract if crowd is None else crowd.contract, seeds)
    pilot = Pilot(policy, contract, agents, simulation.dt_s, crowd)
    before = (simulation.distance_m.copy(), simulation.contacts.copy())
    for step in range(discard + steps):
        if step == discard:
            before = (simulation.distance_m.copy(), simulation.contacts.copy())
        simulation.sense()
        with foreign_code(name):
            actions = pilot.act(simulation.stacks)
        _check_actions(name, actions, agents, len(simulation.contract.actions))
        pilot.begin_anew(simulation.step(actions))
        if progress is not None:
            progress(step + 1, discard + steps)
    did = None if crowd is None else crowd.did
    return _score(simulation.distance_m - before[0], simulation.contacts - before[1], did)


def _check(
    policy: object,
    contract: object,
    agents: int,
    steps: int,
    discard: int,
    seeds: npt.NDArray[np.uint64] | None,
) -> None:
    """Refuse what cannot be measured, before anything is built."""
    if not callable(getattr(policy, "decide", None)):
        raise UsageError(f"policy: expected an object with decide, got {type(policy).__name__}")
    if not isinstance(contract, PolicyContract):
        raise UsageError(f"contract: expected a PolicyContract, got {type(contract).__name__}")
    for name, number, least in (
        ("agents", agents, 1),
        ("steps", steps, 1),
        ("discard", discard, 0),
    ):
        if not isinstance(number, int | np.integer) or number < least:
            raise UsageError(f"{name}: expected a whole number of {least} or more, got {number!r}")
    if seeds is not None and not np.size(seeds):
        raise UsageError("seeds: expected at least one, got none")


def _check_actions(name: str, actions: object, agents: int, count: int) -> None:
    """Refuse decisions that are none, as nothing can be said of who made them."""
    chosen = np.asarray(actions)
    if chosen.shape != (agents,) or not np.issubdtype(chosen.dtype, np.integer):
        raise UsageError(
            f"{name}: expected winners of shape ({agents},), whole numbers, got "
            f"{chosen.dtype} of shape {chosen.shape}"
        )
    if chosen.min() < 0 or chosen.max() >= count:
        wrong = int(chosen.min() if chosen.min() < 0 else chosen.max())
        raise UsageError(f"{name}: expected winners from 0 to {count - 1}, got {wrong}")


def _score(
    distance_m: npt.NDArray[np.float64],
    contacts: npt.NDArray[np.int64],
    did: Interventions | None = None,
) -> FieldScore:
    low, high = _bootstrap_interval(distance_m, contacts)
    return FieldScore(
        contacts_per_100m=100.0 * float(contacts.sum() / max(distance_m.sum(), LEAST_M)),
        low=low,
        high=high,
        distance_m=float(distance_m.sum()),
        contacts=int(contacts.sum()),
        agents=len(contacts),
        guarded=_share(did.guarded, did) if did else 0.0,
        stuck=_share(did.stuck, did) if did else 0.0,
    )


def _share(count: int, did: Interventions) -> float:
    return count / max(1, did.decisions)


def _bootstrap_interval(
    distance_m: npt.NDArray[np.float64], contacts: npt.NDArray[np.int64]
) -> tuple[float, float]:
    """95 % percentile interval of the ratio of sums, agents drawn with replacement."""
    generator = np.random.default_rng(_BOOTSTRAP_SEED)
    n, rates = len(contacts), np.empty(_RESAMPLES)
    for i in range(_RESAMPLES):
        drawn = generator.integers(0, n, n)
        rates[i] = 100.0 * contacts[drawn].sum() / max(distance_m[drawn].sum(), LEAST_M)
    low, high = np.percentile(rates, (2.5, 97.5))
    return float(low), float(high)
