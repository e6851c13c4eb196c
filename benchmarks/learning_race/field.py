"""The reference field as a vector environment of Stable-Baselines3: an adapter of the simulation.

An observation is a retina / 255 to the input power, float32 (agents, 16). There are no episodes: a
contact pays −1 instead of +0.1 and moves the agent elsewhere, as for our learners, and the value of
the next state counts. An action can be held for several world steps, whose rewards are added.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from learning_race.frozen import Floats, seen
from reflexarc_runtime.arrays import Actions
from reflexarc_sim_bridge.environments.episodes import CONTACT_REWARD, STEP_REWARD
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME, reference_contract
from reflexarc_sim_bridge.worlds.seeds import TRAINING_SEEDS


class FieldVecEnv(VecEnv):
    """Agents in the reference field, each in the world of a training seed."""

    def __init__(
        self, agents: int, seed: int, *, input_power: int = 1, held_steps: int = 1
    ) -> None:
        """Put the agents into the worlds of our batched learner with the same seed."""
        contract = reference_contract()
        numbers = (seed * agents + np.arange(agents)) % len(TRAINING_SEEDS)
        seeds = np.array(TRAINING_SEEDS, np.uint64)[numbers]
        self.simulation = Simulation(world_named(WORLD_NAME), contract, seeds)
        self._input_power, self._held_steps = input_power, held_steps
        self._never, self._infos = np.zeros(agents, np.bool_), [{} for _ in range(agents)]
        inputs = spaces.Box(0.0, 1.0, (contract.retina.size,), np.float32)
        super().__init__(agents, inputs, spaces.Discrete(len(contract.actions)))

    def reset(self) -> Floats:
        """Sense; returns the observations (agents, inputs)."""
        self.simulation.sense()
        return seen(self.simulation.stacks, self._input_power)

    def step_async(self, actions: npt.NDArray[Any]) -> None:
        """Keep the actions: (agents,)."""
        self._actions: Actions = actions.astype(np.int64)

    def step_wait(self) -> tuple[Floats, Floats, npt.NDArray[np.bool_], list[dict[str, Any]]]:
        """Move for the held steps, and sense once."""
        contacts = np.zeros(self.num_envs)
        for _ in range(self._held_steps - 1):
            contacts += self.simulation.step(self._actions)
        contacts += self.simulation.step_and_sense(self._actions)
        rewards = STEP_REWARD * self._held_steps + (CONTACT_REWARD - STEP_REWARD) * contacts
        observations = seen(self.simulation.stacks, self._input_power)
        return observations, rewards.astype(np.float32), self._never.copy(), self._infos

    def close(self) -> None:
        """Do nothing: the simulation holds no resources."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute, repeated for each agent."""
        return [getattr(self, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Set an attribute."""
        setattr(self, attr_name, value)

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        """Refuse: there are no single environments to call."""
        raise NotImplementedError(method_name)

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No environment is wrapped."""
        return [False] * self.num_envs
