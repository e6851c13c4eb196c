"""How good the greedy policy is, on validation worlds: what a run may look at while it learns.

The same figure as `reference_field.measure` gives for the network (but for bodies that turn, see
`learner.driven_m`), by a compiled forward pass: a run asks for it twenty times.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.q_network import QNetwork
from reflexarc_trainer.policy.weights import NetworkPolicy, pack
from reflexarc_trainer.sarsa.batched.network_pass import forward_from_python
from reflexarc_trainer.sarsa.learner_interface import driven_m
from reflexarc_trainer.sarsa.network_shape import input_curve, layers_for

RECORDED_AGENTS = 64
RECORDED_EVERY = 10
RECORDED_STEPS = 80


class GreedyPolicy(Policy):
    """A network as a `Policy` that decides for many agents at once, by the compiled forward pass.

    Args:
        network: what was learned.
        config: by which run.
    """

    def __init__(self, network: QNetwork, config: TrainConfig) -> None:
        self._layers = layers_for(config.network, config.contract())
        self._weights = pack(network)
        self._curve = input_curve(config.network, np.float64)

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Q-values (n, actions) and winners (n,) of retinas (n, frames, eyes, rays, channels)."""
        values = np.empty((self._layers.computed, len(retinas)))
        inputs = self._curve[retinas.reshape(len(retinas), -1).T]
        forward_from_python(self._layers, self._weights, inputs, values)
        q_values: npt.NDArray[np.float64] = values[-int(self._layers.sizes[-1]) :]
        winners: Actions = np.argmax(q_values, axis=0)
        return q_values.T.astype(np.float32), winners


class GreedyDriver:
    """A network that drives all agents of a simulation greedily."""

    def __init__(self, network: QNetwork, config: TrainConfig, simulation: Simulation) -> None:
        self._simulation = simulation
        self._policy = GreedyPolicy(network, config)

    def drive(self, steps: int) -> None:
        """Look, decide, act."""
        for _ in range(steps):
            self._simulation.sense()
            self._simulation.step(self._policy.decide(self._simulation.stacks)[1])


def validate(network: QNetwork, config: TrainConfig) -> float:
    """Contacts per 100 m of the greedy policy in the run's world, on validation seeds."""
    scale, seeds = config.validation, validation_seeds(config.validation.agents)
    simulation = Simulation(config.goal_world, config.contract(), seeds)
    driver = GreedyDriver(network, config, simulation)
    driver.drive(scale.discard)
    distance_m, contacts = simulation.distance_m.copy(), simulation.contacts.copy()
    driver.drive(scale.steps)
    progress_m = float((simulation.distance_m - distance_m).sum())
    metres = driven_m(config, simulation.dt_s, scale.agents * scale.steps, progress_m)
    return 100.0 * int((simulation.contacts - contacts).sum()) / metres


def drive_and_record(network: QNetwork, config: TrainConfig) -> RetinaBatch:
    """Retinas that the greedy policy meets, (n, frames, eyes, rays, channels): for the export."""
    seeds = validation_seeds(RECORDED_AGENTS)
    simulation = Simulation(config.goal_world, config.contract(), seeds)
    policy, seen = NetworkPolicy(network), []
    for step in range(RECORDED_STEPS):
        simulation.sense()
        retinas = simulation.stacks.copy()
        if step % RECORDED_EVERY == 0:
            seen.append(retinas)
        simulation.step(policy.decide(retinas)[1])
    return np.concatenate(seen)
