"""How good the greedy policy is, on validation worlds: what a run may look at while it learns."""

import numpy as np
from torch import nn

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.reference_field import measure
from reflexarc_sim_bridge.seeds import validation_seeds
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import world_named
from reflexarc_trainer.config import TrainConfig
from reflexarc_trainer.weights import NetworkPolicy

RECORDED_AGENTS = 64
RECORDED_EVERY = 10
RECORDED_STEPS = 80


def validate(network: nn.Module, config: TrainConfig) -> float:
    """Contacts per 100 m of the greedy policy in the run's world, on validation seeds."""
    scale = config.validation
    score = measure(
        NetworkPolicy(network),
        config.contract(),
        agents=scale.agents,
        steps=scale.steps,
        discard=scale.discard,
        seeds=validation_seeds(scale.agents),
        world=world_named(config.world),
    )
    return float(score.contacts_per_100m)


def drive_and_record(network: nn.Module, config: TrainConfig) -> RetinaBatch:
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
