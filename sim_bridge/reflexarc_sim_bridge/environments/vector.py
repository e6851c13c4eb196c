"""Many agents, each in a world of its own, as one Gymnasium vector environment.

All agents take a compiled step together. An agent whose episode has ended begins the next one at
the following step, which ignores its action and rewards it with 0: Gymnasium's next-step
autoreset. With the same seeds each agent gets the observations and rewards of a single environment
(`single.py`), step by step, to the bit.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from reflexarc_runtime.arrays import Actions, Mask
from reflexarc_runtime.config.checks import require
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.environments.episodes import (
    CONTACT_REWARD,
    EPISODE_STEPS,
    INFO,
    STEP_REWARD,
    Indices,
    Seeds,
    WorldSequence,
    action_space,
    checked_seeds,
    ends_at_contact,
    observation_space,
    the_world,
)
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME, reference_contract
from reflexarc_sim_bridge.worlds.world import WorldSource

_require = partial(require, error=WorldError)

Observations = npt.NDArray[np.uint8]
Step = tuple[Observations, npt.NDArray[np.float64], Mask, Mask, dict[str, Any]]


class ReferenceVectorEnv(VectorEnv[Observations, Actions, npt.NDArray[Any]]):
    """Agents in the reference field, or in worlds of another kind, with any supported contract.

    Observations: uint8 (n, frames · eyes · rays · channels), each row as `ReferenceEnv` has it.
    Actions: integers (n,). Infos: `x_m`, `y_m`, `distance_m`, `contacts`, (n,) each, of all agents.
    Everything returned is the caller's to keep.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  # gymnasium's own declaration
        "render_modes": [],
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }

    def __init__(
        self,
        num_envs: int = 1,
        contract: PolicyContract | None = None,
        world: WorldSource | str = WORLD_NAME,
        max_episode_steps: int | None = EPISODE_STEPS,
    ) -> None:
        """Build the simulation; `reset` begins the episodes.

        Args:
            num_envs: how many agents.
            contract: what they see and how each action moves them; the reference's if None.
            world: the kind of world, or its name.
            max_episode_steps: an episode is truncated after so many; None: never.

        Raises:
            WorldError: no such world, or a contract or number that is not supported.
        """
        _require(num_envs >= 1, "num_envs", "1 or more", num_envs)
        limit = max_episode_steps
        _require(limit is None or limit >= 1, "max_episode_steps", "1 or more, or None", limit)
        contract = contract or reference_contract()
        self.num_envs = num_envs
        self.single_observation_space = observation_space(contract)
        self.single_action_space = action_space(contract)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._terminates = ends_at_contact(the_world(world))
        self._max_steps = np.iinfo(np.int64).max if limit is None else limit
        self._worlds = WorldSequence(num_envs)
        seeds = np.arange(num_envs, dtype=np.uint64)
        self._simulation = Simulation(the_world(world), contract, seeds)
        self._steps = np.zeros(num_envs, np.int64)
        self._has_ended = np.zeros(num_envs, np.bool_)
        self._has_begun = False

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observations, dict[str, Any]]:
        """Begin all episodes, or those of `options["reset_mask"]`: bool (n,).

        Args:
            seed: of the worlds: s for s, s + 1, s + 2 …, or a list with one for each agent; where
                it is None, the next world of the agent's sequence.
            options: `reset_mask`; other keys are ignored.

        Raises:
            WorldError: seeds or a mask of another form.
            ClosedEnvironmentError: the environment is closed.
            ResetNeeded: a mask before the first reset.
        """
        self._require_open()
        super().reset(seed=seed if isinstance(seed, int) else None)
        which = np.arange(self.num_envs)
        if options and "reset_mask" in options:
            self._require_begun()
            which = self._marked(options["reset_mask"])
        self._seed(which, seed)
        self._place(which)
        self._sense(which)
        self._has_ended[which], self._has_begun = False, True
        return self._observations(), self._infos()

    def step(self, actions: Actions) -> Step:
        """Move every agent, put those whose episode has ended into their next world, and look.

        Raises:
            WorldError: actions of another shape or type, or that the contract does not have.
            ClosedEnvironmentError: the environment is closed.
            ResetNeeded: before the first reset.
        """
        self._require_open()
        self._require_begun()
        some_ended = bool(self._has_ended.any())
        move = self._simulation.step if some_ended else self._simulation.step_and_sense
        met = move(_as_indices(actions))
        rewards = np.where(met, CONTACT_REWARD, STEP_REWARD)
        self._steps += 1
        if some_ended:
            self._place(ended := np.flatnonzero(self._has_ended))
            self._simulation.sense()
            rewards[ended], met[ended] = 0.0, False
        terminations = met if self._terminates else np.zeros(self.num_envs, np.bool_)
        truncations = self._steps >= self._max_steps
        self._has_ended = terminations | truncations
        return self._observations(), rewards, terminations, truncations, self._infos()

    def _place(self, which: Indices) -> None:
        """Put agents into their next worlds, before their first look."""
        self._simulation.place(which, self._worlds.next(which, self.np_random))
        self._steps[which] = 0

    def _sense(self, which: Indices) -> None:
        """Let only some agents look, as every look advances the frames of an agent."""
        if len(which) == self.num_envs:
            self._simulation.sense()
            return
        for i in which.tolist():
            self._simulation.look(i, i + 1)

    def _seed(self, which: Indices, seed: int | Sequence[int | None] | None) -> None:
        if seed is None:
            return
        seeds = [seed + i for i in range(self.num_envs)] if isinstance(seed, int) else list(seed)
        _require(len(seeds) == self.num_envs, "seed", f"{self.num_envs}, one an agent", len(seeds))
        given = [(i, int(seeds[i])) for i in which.tolist() if seeds[i] is not None]
        numbers: Seeds = checked_seeds([seed for _, seed in given])
        self._worlds.seed(np.array([i for i, _ in given], np.int64), numbers)

    def _marked(self, mask: Any) -> Indices:
        """Indices of the agents of a mask."""
        fits = isinstance(mask, np.ndarray) and mask.dtype == np.bool_
        fits = fits and mask.shape == (self.num_envs,) and bool(mask.any())
        wanted = f"bool ({self.num_envs},) with an agent in it"
        _require(fits, "reset_mask", wanted, repr(mask))
        return np.flatnonzero(mask)

    def _observations(self) -> Observations:
        return self._simulation.params.agents.stack.copy()

    def _infos(self) -> dict[str, Any]:
        return {name: np.array(getattr(self._simulation, name)) for name in INFO}

    def _require_open(self) -> None:
        if self.closed:
            raise gymnasium.error.ClosedEnvironmentError("the environment is closed; make another")

    def _require_begun(self) -> None:
        if not self._has_begun:
            raise gymnasium.error.ResetNeeded("call reset() before step() and partial resets")


def _as_indices(actions: Any) -> Actions:
    """Integers of any type as int64; other types are left for the simulation to refuse."""
    array = np.asarray(actions)
    return np.ascontiguousarray(array, np.int64) if array.dtype.kind in "iu" else array
