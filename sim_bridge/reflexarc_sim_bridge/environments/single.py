"""One agent in a world, as a Gymnasium environment: `reflexarc/Reference-v1` and its like.

The task is continuing: a contact costs 1 and the agent goes on elsewhere, so an episode is never
terminated, only truncated by the time limit; value learners bootstrap through it. Only a world
whose contacts end the episode (`after_contact`: terminate) terminates. `reset(seed=…)` chooses the
world; without a seed each episode is in a new world drawn from the last seed (`episodes.py`).
"""

from operator import index
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.environments.episode_frames import EpisodeFrames
from reflexarc_sim_bridge.environments.episodes import (
    CONTACT_REWARD,
    INFO,
    STEP_REWARD,
    WorldSequence,
    action_space,
    checked_seeds,
    ends_at_contact,
    observation_space,
    the_world,
)
from reflexarc_sim_bridge.environments.raster import Pixels
from reflexarc_sim_bridge.environments.window import Window
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.single_agent import REFUSED, OneAgent
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME, reference_contract
from reflexarc_sim_bridge.worlds.world import WorldSource

_REWARDS = (STEP_REWARD, CONTACT_REWARD)
_MODES = "rgb_array, human or None"
_ONLY = np.zeros(1, np.int64)


class ReferenceEnv(gymnasium.Env[npt.NDArray[np.uint8], np.int64]):
    """One agent in the reference field, or in another world, with any supported contract.

    Observation: what the policy sees, flat, uint8 (frames · eyes · rays · channels,): oldest frame
    first, ray 0 the leftmost; `reshape(contract.retina.stack_shape)` gives the axes back. Action:
    an index into the contract's actions, by default stay, left, right. Reward: 0.1 a step, −1 for
    one with a contact. Info: `x_m`, `y_m`, `distance_m`, `contacts` of the episode. With a render
    mode: the world from above, around the agent, uint8 (480, 480, 3).
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  # gymnasium's own declaration
        "render_modes": ["rgb_array", "human"],
        "render_fps": 10,
    }

    def __init__(
        self,
        contract: PolicyContract | None = None,
        world: WorldSource | str = WORLD_NAME,
        render_mode: str | None = None,
    ) -> None:
        """Build the simulation; `reset` begins an episode.

        Args:
            contract: what the agent sees and how each action moves it; the reference's if None.
            world: the kind of world, or its name.
            render_mode: `rgb_array`: `render` gives a frame; `human`: each step shows one in a
                window, at the world's own pace; None: nothing is drawn, and nothing costs.

        Raises:
            WorldError: no such world or mode, or a contract that the simulator does not support.
        """
        modes = (None, *self.metadata["render_modes"])
        require(render_mode in modes, "render_mode", _MODES, repr(render_mode), error=WorldError)
        self._contract = contract or reference_contract()
        self.observation_space = observation_space(self._contract)
        self.action_space = action_space(self._contract)
        self._terminates = ends_at_contact(the_world(world))
        self._worlds = WorldSequence(1)
        seeds = np.zeros(1, np.uint64)
        self._agent = OneAgent(Simulation(the_world(world), self._contract, seeds))
        self._has_begun = False
        self.render_mode = render_mode
        rate_hz = 1.0 / self._agent.simulation.dt_s
        self.metadata = self.metadata | {"render_fps": rate_hz}
        self._frames = None if render_mode is None else EpisodeFrames(self._agent.simulation)
        self._window = Window("reflexarc", rate_hz) if render_mode == "human" else None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[npt.NDArray[np.uint8], dict[str, Any]]:
        """Begin in the world of `seed`, or in a new one.

        Raises:
            WorldError: not a seed of a world.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._worlds.seed(_ONLY, checked_seeds([seed]))
        simulation = self._agent.simulation
        simulation.place(_ONLY, self._worlds.next(_ONLY, self.np_random))
        self._agent.sense()
        self._has_begun = True
        if self._frames is not None:
            self._frames.begin()
            self._show()
        info = {name: getattr(simulation, name)[0].item() for name in INFO}
        return self._agent.stack.copy(), info

    def step(
        self, action: np.int64
    ) -> tuple[npt.NDArray[np.uint8], float, bool, bool, dict[str, Any]]:
        """Move once, then look.

        Raises:
            WorldError: an action that the contract does not have; or a list of obstacles was full.
            ResetNeeded: before the first reset.
        """
        if not self._has_begun:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        try:
            met, x_m, y_m, distance_m, contacts = self._agent.step_and_sense(index(action))
        except OverflowError:  # a list was full; or the action is beyond 64 bits
            self._agent.require_nothing_lost()
            met = REFUSED
        if met == REFUSED:
            known = len(self._contract.actions)
            raise WorldError(f"action: expected 0 to {known - 1}, the contract's, got {action}")
        if self._frames is not None:
            self._frames.went_on(met=met == 1)
            self._show()
        info = {"x_m": x_m, "y_m": y_m, "distance_m": distance_m, "contacts": contacts}
        return self._agent.stack.copy(), _REWARDS[met], self._terminates and met == 1, False, info

    def render(self) -> Pixels | None:
        """The frame of mode `rgb_array`: uint8 (480, 480, 3); None in the others.

        Raises:
            ResetNeeded: before the first reset.
        """
        if not self._has_begun:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        if self._frames is None or self._window is not None:
            return None
        return self._frames.frame()

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def _show(self) -> None:
        """Of mode `human`: the window shows what is now."""
        if self._window is not None and self._frames is not None:
            self._window.show(self._frames.frame())
