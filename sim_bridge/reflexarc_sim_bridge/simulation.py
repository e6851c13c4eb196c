"""Agents in their worlds, from Python: one sense and one step for all of them at once."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions
from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge import kernel
from reflexarc_sim_bridge.chunks import OBSTACLE_DTYPE
from reflexarc_sim_bridge.params import (
    NEAR_COLOUR,
    NEAR_HALF_LENGTH,
    NEAR_HALF_WIDTH,
    NEAR_ROUND,
    NEAR_X,
    NEAR_Y,
    Agents,
    EyeParams,
    WorldParams,
    agents_at_zero,
    eye_params,
    world_params,
)
from reflexarc_sim_bridge.worlds import World


class Params(NamedTuple):
    """What compiled callers hand to `kernel`."""

    world: WorldParams
    eye: EyeParams
    agents: Agents


class Simulation:
    """Many agents with one kind of eye, each in the world of its seed.

    Every agent begins at x = 0, at a y drawn uniformly among the free places. Agents with the same
    seed share the world and nothing else: they do not see each other, and start apart. The same
    world, contract and seeds give the same bits, on any number of threads.
    """

    def __init__(
        self, world: World, contract: PolicyContract, seeds: npt.NDArray[np.uint64]
    ) -> None:
        """Put the agents into their worlds.

        Args:
            world: the kind of world.
            contract: what the agents see and how each action moves them.
            seeds: one an agent: (n,).

        Raises:
            WorldError: a contract or seeds that this simulation does not support.
        """
        _check_supported(contract)
        if seeds.ndim != 1 or len(seeds) == 0 or seeds.dtype != np.uint64:
            raise WorldError(f"seeds: expected uint64 (n,), got {seeds.dtype} {seeds.shape}")
        self.world = world
        self.contract = contract
        params = world_params(world, contract)
        agents = agents_at_zero(seeds, world, params, contract.retina.rays)
        self.params = Params(params, eye_params(contract.retina, world.scanner), agents)
        self._linear_mps = np.array([action.linear_mps for action in contract.actions])
        self._lateral_mps = np.array([action.lateral_mps for action in contract.actions])
        kernel.place_all(params, agents)

    def __len__(self) -> int:
        return len(self.params.agents.x_m)

    @property
    def x_m(self) -> npt.NDArray[np.float64]:
        """Where the agents are, ahead: (n,). Changes with every step; copy it to keep it."""
        return self.params.agents.x_m

    @property
    def y_m(self) -> npt.NDArray[np.float64]:
        """Where the agents are, to the left: (n,). Changes with every step."""
        return self.params.agents.y_m

    @property
    def distance_m(self) -> npt.NDArray[np.float64]:
        """Progress along x since the start: (n,). Changes with every step."""
        return self.params.agents.distance_m

    @property
    def contacts(self) -> npt.NDArray[np.int64]:
        """Contacts since the start: (n,). Changes with every step."""
        return self.params.agents.contacts

    def sense(self) -> npt.NDArray[np.uint8]:
        """What every agent sees now: (n, eyes, rays, channels), a new array."""
        retinas = np.empty((len(self), self.contract.retina.rays), np.uint8)
        if len(self) == 1:  # one agent needs no threads, and no time to compile and start them
            kernel.sense_agent(*self.params, 0, retinas[0])
        else:
            kernel.sense_all(*self.params, retinas)
        return retinas.reshape(len(self), *self.contract.retina.shape)

    def step(self, actions: Actions) -> npt.NDArray[np.bool_]:
        """Move every agent for `world.dt_s`.

        Args:
            actions: indices into the contract's actions: (n,).

        Returns:
            Which agents met an obstacle, and now stand at another place of the same x: (n,).

        Raises:
            WorldError: actions of another shape or type, or that the contract does not have.
        """
        _check_actions(actions, len(self), len(self._linear_mps))
        met = np.empty(len(self), np.bool_)
        world, _, agents = self.params
        if len(self) == 1:
            linear_mps, lateral_mps = self._linear_mps[actions[0]], self._lateral_mps[actions[0]]
            met[0] = kernel.step_agent(world, agents, 0, linear_mps, lateral_mps)
        else:
            kernel.step_all(world, agents, self._linear_mps, self._lateral_mps, actions, met)
        return met

    def obstacles_near(self, agent: int) -> npt.NDArray[np.void]:
        """Obstacles near an agent, beside it (y may leave the period), for drawing: (count,).

        Everything within the eye's reach is there, and some of what lies just beyond it.
        """
        rows = self.params.agents.near[agent, :, : self.params.agents.near_count[agent]]
        obstacles = np.zeros(rows.shape[1], OBSTACLE_DTYPE)
        obstacles["x_m"], obstacles["y_m"] = rows[NEAR_X], rows[NEAR_Y]
        obstacles["half_length_m"] = rows[NEAR_HALF_LENGTH]
        obstacles["half_width_m"] = rows[NEAR_HALF_WIDTH]
        obstacles["round"] = rows[NEAR_ROUND] != 0.0
        obstacles["colour"] = rows[NEAR_COLOUR]
        return obstacles

    def state(self) -> dict[str, npt.NDArray[np.generic]]:
        """Everything that changes, copied, by name: what `restore` takes."""
        return {name: array.copy() for name, array in self.params.agents._asdict().items()}

    def restore(self, state: dict[str, npt.NDArray[np.generic]]) -> None:
        """Go back to a state of a simulation of the same world, contract and number of agents.

        Raises:
            WorldError: an array is missing or has another shape or type.
        """
        mine = self.params.agents._asdict()
        for name, array in mine.items():
            _check_same_form(name, state.get(name), array)
        for name, array in mine.items():
            array[...] = state[name]


def _check_supported(contract: PolicyContract) -> None:
    retina, actions = contract.retina, contract.actions
    _require(retina.eyes == 1, "retina.eyes", "1", retina.eyes)
    _require(retina.channels == 1, "retina.channels", "1 (grey)", retina.channels)
    _require(retina.frames == 1, "retina.frames", "1", retina.frames)
    turning = [action.name for action in actions if action.angular_radps != 0.0]
    _require(not turning, "actions", "no angular speed", turning)
    forward_mps = {action.linear_mps for action in actions}
    _require(len(forward_mps) == 1, "actions", "one forward speed for all", forward_mps)


def _check_actions(actions: Actions, agents: int, known: int) -> None:
    if actions.shape != (agents,) or actions.dtype != np.int64:
        got = f"{actions.dtype} {actions.shape}"
        raise WorldError(f"actions: expected int64 ({agents},), one an agent, got {got}")
    if actions.min() < 0 or actions.max() >= known:
        got = f"{actions.min()} to {actions.max()}"
        raise WorldError(f"actions: expected 0 to {known - 1}, the contract's, got {got}")


def _check_same_form(
    name: str, got: npt.NDArray[np.generic] | None, mine: npt.NDArray[np.generic]
) -> None:
    wanted = f"{mine.dtype} {mine.shape}"
    if got is None:
        raise WorldError(f"state.{name}: expected {wanted}, got nothing")
    if got.shape != mine.shape or got.dtype != mine.dtype:
        raise WorldError(
            f"state.{name}: expected {wanted}, got {got.dtype} {got.shape}; restore into the same "
            "world, contract and number of agents"
        )


def _require(holds: bool, where: str, expected: str, got: object) -> None:
    if not holds:
        raise WorldError(
            f"contract.{where}: the simulator supports {expected}, got {got}; choose another policy"
        )
