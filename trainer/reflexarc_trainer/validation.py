"""How good the greedy policy is, on validation worlds: what a run may look at while it learns.

The same figure as `reference_field.measure` gives for the network, in one compiled call: a run asks
for it twenty times, on worlds so few that a call a step would cost more than the steps.
"""

import numpy as np

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.compiled import compiled_parallel, prange
from reflexarc_sim_bridge.kernel import sense_agent, step_agent
from reflexarc_sim_bridge.params import Agents, EyeParams, WorldParams
from reflexarc_sim_bridge.seeds import validation_seeds
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import world_named
from reflexarc_trainer.choice import winner
from reflexarc_trainer.config import TrainConfig
from reflexarc_trainer.learner import motions_of, rules_for
from reflexarc_trainer.online import Floats, Rules, forward, see
from reflexarc_trainer.q_network import QNetwork
from reflexarc_trainer.weights import NetworkPolicy, pack

RECORDED_AGENTS = 64
RECORDED_EVERY = 10
RECORDED_STEPS = 80


def validate(network: QNetwork, config: TrainConfig) -> float:
    """Contacts per 100 m of the greedy policy in the run's world, on validation seeds."""
    contract, scale = config.contract(), config.validation
    seeds = validation_seeds(scale.agents)
    simulation = Simulation(world_named(config.world), contract, seeds)
    rules, weights = rules_for(config.learner, contract, config.steps), pack(network)
    world, eye, agents = simulation.params
    motions_mps = motions_of(contract)
    drive_greedily(rules, weights, world, eye, agents, motions_mps, scale.discard)
    distance_m, contacts = simulation.distance_m.copy(), simulation.contacts.copy()
    drive_greedily(rules, weights, world, eye, agents, motions_mps, scale.steps)
    driven_m = float((simulation.distance_m - distance_m).sum())
    return 100.0 * int((simulation.contacts - contacts).sum()) / driven_m


def drive_and_record(network: QNetwork, config: TrainConfig) -> RetinaBatch:
    """Retinas that the greedy policy meets, (n, frames, eyes, rays, channels): for the export."""
    seeds = validation_seeds(RECORDED_AGENTS)
    simulation = Simulation(world_named(config.world), config.contract(), seeds)
    policy, seen = NetworkPolicy(network), []
    for step in range(RECORDED_STEPS):
        retinas = simulation.sense().reshape(-1, *config.retina.stack_shape)
        if step % RECORDED_EVERY == 0:
            seen.append(retinas)
        simulation.step(policy.decide(retinas)[1])
    return np.concatenate(seen)


@compiled_parallel
def drive_greedily(
    rules: Rules,
    weights: Floats,
    world: WorldParams,
    eye: EyeParams,
    agents: Agents,
    motions_mps: Floats,
    steps: int,
) -> None:
    """Look, decide, act, for all agents; `motions_mps` is (actions, 2): linear, lateral."""
    for i in prange(agents.x_m.size):
        retina = np.zeros(rules.inputs, np.uint8)
        inputs, hidden = np.ones(rules.inputs + 1), np.ones(rules.hidden + 1)
        q_values = np.zeros(rules.actions)
        for _ in range(steps):
            sense_agent(world, eye, agents, i, retina)
            see(retina, inputs)
            forward(rules, weights, inputs, hidden, q_values)
            action = winner(q_values)
            step_agent(world, agents, i, motions_mps[action, 0], motions_mps[action, 1])
