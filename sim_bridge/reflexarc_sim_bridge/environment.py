"""The reference field for one agent, as a Gymnasium environment: `reflexarc/Reference-v1`.

The task is continuing: a contact costs 1 and the agent goes on elsewhere, so an episode is never
terminated, only truncated by the time limit; value learners bootstrap through it. `reset(seed=…)`
chooses the world; without a seed each episode is a new world from the environment's own stream.
"""

from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract
from reflexarc_sim_bridge.reference_field import WORLD_NAME, reference_contract
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import World, world_named

REFERENCE_ID = "reflexarc/Reference-v1"
EPISODE_STEPS = 1000

STEP_REWARD = 0.1
"""For a step without contact (the paper, section 4.2)."""
CONTACT_REWARD = -1.0
"""For a step with one (the same)."""


class ReferenceEnv(gymnasium.Env[npt.NDArray[np.uint8], np.int64]):
    """One agent in the reference field, or in another world, with any supported contract.

    Observation: uint8 (rays,), ray 0 the leftmost. Action: an index into the contract's actions,
    here stay, left, right. Info: `x_m`, `y_m`, `distance_m`, `contacts` of the episode.
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012  # gymnasium's own declaration

    def __init__(self, contract: PolicyContract | None = None, world: World | None = None) -> None:
        self._contract = contract or reference_contract()
        self._world = world or world_named(WORLD_NAME)
        rays, actions = self._contract.retina.rays, len(self._contract.actions)
        self.observation_space = gymnasium.spaces.Box(0, 255, (rays,), np.uint8)
        self.action_space = gymnasium.spaces.Discrete(actions)
        self._simulation: Simulation | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.uint8], dict[str, Any]]:
        """Begin in the world of `seed`, or in a new one."""
        super().reset(seed=seed)
        world_seed = self.np_random.integers(1 << 63) if seed is None else seed
        seeds = np.array([world_seed], np.uint64)
        self._simulation = Simulation(self._world, self._contract, seeds)
        return self._observed(), self._info()

    def step(
        self, action: np.int64
    ) -> tuple[npt.NDArray[np.uint8], float, bool, bool, dict[str, Any]]:
        """Move once."""
        met = self._running().step(np.array([action], np.int64))[0]
        reward = CONTACT_REWARD if met else STEP_REWARD
        return self._observed(), reward, False, False, self._info()

    def _observed(self) -> npt.NDArray[np.uint8]:
        return self._running().sense().reshape(-1)

    def _info(self) -> dict[str, Any]:
        simulation = self._running()
        names = ("x_m", "y_m", "distance_m", "contacts")
        return {name: getattr(simulation, name)[0].item() for name in names}

    def _running(self) -> Simulation:
        if self._simulation is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        return self._simulation


gymnasium.register(
    REFERENCE_ID,
    entry_point="reflexarc_sim_bridge.environment:ReferenceEnv",
    max_episode_steps=EPISODE_STEPS,
)
