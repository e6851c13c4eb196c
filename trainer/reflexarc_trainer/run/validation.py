"""Validation: contacts per 100 m of the greedy policy, on worlds kept for this.

The figure equals that of `evaluation/reference_field.py` (except for bodies that turn: see
`learner_interface.driven_m`). It is computed by the compiled forward pass, as a run needs it often.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
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
"""World steps between two recorded retinas of an agent."""
RECORDED_STEPS = 80


class GreedyPolicy(Policy):
    """A network as a greedy `Policy` for many agents at once, by the compiled forward pass.

    Args:
        network: the learned network.
        config: the run that learned it.
    """

    def __init__(self, network: QNetwork, config: TrainConfig) -> None:
        self._layers = layers_for(config.network, config.contract())
        self._weights = pack(network)
        self._curve = input_curve(config.network, np.float64)

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Q-values (n, actions), actions (n,) of retinas (n, frames, eyes, rays, channels)."""
        values = np.empty((self._layers.computed, len(retinas)))
        inputs = self._curve[retinas.reshape(len(retinas), -1).T]
        forward_from_python(self._layers, self._weights, inputs, values)
        q_values: npt.NDArray[np.float64] = values[-int(self._layers.sizes[-1]) :]
        actions: Actions = np.argmax(q_values, axis=0)
        return q_values.T.astype(np.float32), actions


class GreedyDriver:
    """Drives all agents of a simulation by a network's greedy policy."""

    def __init__(self, network: QNetwork, config: TrainConfig, simulation: Simulation) -> None:
        self._simulation = simulation
        policy, agents = GreedyPolicy(network, config), len(simulation.x_m)
        self._pilot = Pilot(policy, config.contract(), agents, simulation.dt_s)

    def drive(self, steps: int) -> None:
        """Sense, decide and act for a number of world steps."""
        for _ in range(steps):
            self._simulation.sense()
            met = self._simulation.step(self._pilot.act(self._simulation.stacks))
            self._pilot.begin_anew(met)


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
    """Retinas of a drive with the greedy policy: (n, frames, eyes, rays, channels)."""
    seeds = validation_seeds(RECORDED_AGENTS)
    simulation = Simulation(config.goal_world, config.contract(), seeds)
    policy, recorded = NetworkPolicy(network), []
    for step in range(RECORDED_STEPS):
        simulation.sense()
        retinas = simulation.stacks.copy()
        if step % RECORDED_EVERY == 0:
            recorded.append(retinas)
        simulation.step(policy.decide(retinas)[1])
    return np.concatenate(recorded)
