"""Agents in their worlds, from Python: one sense and one step for all of them at once."""

from functools import partial
from threading import get_ident
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.arrays.agent_arrays import agents_at_zero
from reflexarc_sim_bridge.arrays.eyes import eye_params
from reflexarc_sim_bridge.arrays.layout import Params
from reflexarc_sim_bridge.arrays.true_bearings import true_bearings
from reflexarc_sim_bridge.arrays.world_tables import world_tables, write_world
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.native.threads import shared
from reflexarc_sim_bridge.simulation.array_checks import check_actions, check_same_form, check_seeds
from reflexarc_sim_bridge.simulation.lost_obstacles import require_nothing_lost
from reflexarc_sim_bridge.simulation.scene import Outline, outlines_near
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE, PLACE, call_cast, direct_call_step
from reflexarc_sim_bridge.simulation.step_compilation import cast_for, step_for
from reflexarc_sim_bridge.simulation.step_pointer import new_held
from reflexarc_sim_bridge.worlds.layers import CHUNK_M
from reflexarc_sim_bridge.worlds.world import World, WorldSource

_OF_THIS_PROCESS = "_step", "_held", "_call_step"
"""Attributes of a simulation that hold addresses."""

__all__ = ["Params", "Simulation", "motions_of"]


def motions_of(contract: PolicyContract) -> npt.NDArray[np.float64]:
    """Linear, lateral and angular speed of each action: (actions, 3)."""
    return np.array([(a.linear_mps, a.lateral_mps, a.angular_radps) for a in contract.actions])


class Simulation:
    """Many agents with one kind of eye, each in the world of its seed.

    Every agent begins at x = 0, at a y drawn uniformly among the free places. Agents with the same
    seed share the world and nothing else: they do not see each other, and start apart. The same
    world, contract and seeds give the same bits, on any number of threads.
    """

    def __init__(
        self,
        world: WorldSource,
        contract: PolicyContract,
        seeds: npt.NDArray[np.uint64],
        lanes: npt.NDArray[np.uint64] | None = None,
        *,
        all_round: bool = False,
    ) -> None:
        """Put the agents into their worlds.

        Args:
            world: the kind of world.
            contract: what the agents see and how each action moves them.
            seeds: one an agent: (n,).
            lanes: tell agents of one seed apart: (n,); by default 0, 1, … for each seed.
            all_round: keep near lists of what lies behind the agents too, where their eyes need
                not look, for `AgentSurroundings`. Nothing that they see or meet differs.

        Raises:
            WorldError: a contract or seeds that this simulation does not support.
        """
        check_seeds(seeds)
        prepare()
        self.world = world
        self.contract = contract
        self.all_round = all_round
        worlds = [world] if isinstance(world, World) else [world.drawn(s) for s in seeds.tolist()]
        tables = room = world_tables(worlds, contract, world.fullest, all_round=all_round)
        if not isinstance(world, World):
            room = world_tables(world.fullest, contract, all_round=all_round)
        agents = agents_at_zero(seeds, tables, room, contract)
        if lanes is not None:
            agents.state["lane"] = lanes
        self._motions = motions_of(contract)
        self.params = Params(tables, eye_params(contract, worlds[0]), agents)
        self._no_actions, self._met = np.zeros(len(seeds), np.int64), np.zeros(len(seeds), np.bool_)
        shared(self._put, len(seeds))

    def __getstate__(self) -> dict[str, Any]:
        """All but addresses, which mean nothing in another process."""
        return {name: it for name, it in vars(self).items() if name not in _OF_THIS_PROCESS}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Take what `__getstate__` gave, and find the step in this process."""
        vars(self).update(state)
        prepare()
        self._find_step()

    @property
    def params(self) -> Params:
        """The world, the eye and the agents, as compiled code has them."""
        return self._params

    @params.setter
    def params(self, params: Params) -> None:
        """Go on with others: what compiled code holds are addresses of the former ones."""
        self._params = params
        self._find_step()

    def _find_step(self) -> None:
        self._step = step_for(self.world, self._params, self._motions)
        self._held: dict[int, Struct] = {}  # one a thread
        self._call_step = direct_call_step()

    def __len__(self) -> int:
        return len(self.params.agents.state)

    @property
    def dt_s(self) -> float:
        """Duration of a step; where their worlds differ in it, the mean over the agents."""
        return float(self.params.world.planes["dt_s"].mean())

    @property
    def x_m(self) -> npt.NDArray[np.float64]:
        """Where the agents are, ahead: (n,), a new array."""
        state = self.params.agents.state
        x_m: npt.NDArray[np.float64] = state["cell_x"] * CHUNK_M + state["x_m"]
        return x_m

    @property
    def y_m(self) -> npt.NDArray[np.float64]:
        """Where the agents are, to the left, within the period: (n,), a new array."""
        state = self.params.agents.state
        sides_m = self.params.world.planes["chunk_width_m"][state["world"]]
        y_m: npt.NDArray[np.float64] = state["cell_y"] * sides_m + state["y_m"]
        return y_m

    @property
    def heading_rad(self) -> npt.NDArray[np.float64]:
        """Where the agents look, counter-clockwise from x: (n,), a new array."""
        return self.params.agents.state["heading_rad"].copy()

    @property
    def distance_m(self) -> npt.NDArray[np.float64]:
        """Progress along x since the start: (n,). Changes with every step; copy it to keep it."""
        return self.params.agents.state["distance_m"]

    @property
    def contacts(self) -> npt.NDArray[np.int64]:
        """Contacts since the start: (n,). Changes with every step."""
        return self.params.agents.state["contacts"]

    @property
    def bearings_rad(self) -> npt.NDArray[np.float64]:
        """Where the sub-rays of an eye look on the body, in the order of the retina's rays.

        (rays · samples,), or as many beams. As they really look: see `true_bearings`.

        Behind a scanner a ray may have all beams of its sector; some then stand there twice.
        """
        return np.array(true_bearings(self.contract.retina, self.world.drawn(0)).bearings_rad)

    @property
    def stacks(self) -> RetinaBatch:
        """What the policies see after the last look: (n, frames, eyes, rays, channels).

        Changes with every look.
        """
        return self.params.agents.stack.reshape(len(self), *self.contract.retina.stack_shape)

    def advance(
        self, actions: Actions, met: npt.NDArray[np.bool_], tasks: int, first: int, end: int
    ) -> None:
        """What `step.advance` does, for some of the agents, by the thread that calls.

        Args:
            actions: one an agent: (n,).
            met: filled where they move: which met an obstacle: (n,).
            tasks: sum of `PLACE`, `MOVE` and `LOOK`.
            first: first agent.
            end: agent behind the last.

        Raises:
            WorldError: see `require_nothing_lost`.
        """
        thread = get_ident()
        if thread not in self._held:
            self._held[thread] = self._new_held(self._motions)
        held = self._held[thread]
        self._call_step(self._step.advance, held, actions, met, tasks, first, end)
        self.require_nothing_lost(held)

    def _new_held(self, motions: npt.NDArray[np.float64]) -> Struct:
        return new_held(self.params, motions, self._step.parts)

    def held_step(self) -> tuple[FunctionPointer, Struct]:
        """For other compiled functions: `step.advance`, and what one thread holds."""
        return self._step.advance, self._new_held(self._motions)

    def require_nothing_lost(self, held: Struct) -> None:
        """For who calls the step from compiled code: to be asked when that has returned.

        Args:
            held: what the step was called with.

        Raises:
            WorldError: a list of obstacles was full, so that some could not be seen or met.
        """
        require_nothing_lost(self.world.name, self.params, held.value.work)

    def sense(self) -> npt.NDArray[np.uint8]:
        """Let every agent look, once a step: (n, eyes, rays, channels), a new array."""
        self._advance(self._no_actions, self._met, LOOK)
        return self.stacks[:, -1].copy()

    def look(self, first: int, end: int) -> None:
        """Let only the agents from `first` to `end` look; what they see is in `stacks`."""
        self.advance(self._no_actions, self._met, LOOK, first, end)

    def step(self, actions: Actions) -> npt.NDArray[np.bool_]:
        """Move every agent for a step of its world.

        Args:
            actions: indices into the contract's actions: (n,).

        Returns:
            Which agents met an obstacle: (n,). They now stand at another place of the same x,
            unless contacts make ghosts of them.

        Raises:
            WorldError: actions of another shape or type, or that the contract does not have.
        """
        check_actions(actions, len(self), len(self._motions))
        met = np.empty(len(self), np.bool_)
        self._advance(actions, met, MOVE)
        return met

    def step_and_sense(self, actions: Actions) -> npt.NDArray[np.bool_]:
        """Move every agent and let it look at once, which is quicker: as `step` and `sense`.

        What they see is in `stacks`.
        """
        check_actions(actions, len(self), len(self._motions))
        met = np.empty(len(self), np.bool_)
        self._advance(actions, met, MOVE + LOOK)
        return met

    def _put(self, first: int, end: int) -> None:
        """Let some of the agents take places."""
        self.advance(self._no_actions, self._met, PLACE, first, end)

    def _advance(self, actions: Actions, met: npt.NDArray[np.bool_], tasks: int) -> None:
        shared(partial(self.advance, actions, met, tasks), len(self))

    def drive(self, linear_mps: float, lateral_mps: float, angular_radps: float) -> bool:
        """Move the first agent at any speeds; whether it met an obstacle."""
        motions = np.array([[linear_mps, lateral_mps, angular_radps]])
        action, met = np.zeros(1, np.int64), np.empty(1, np.bool_)
        held = self._new_held(motions)
        self._call_step(self._step.advance, held, action, met, MOVE, 0, 1)
        self.require_nothing_lost(held)
        return bool(met[0])

    def place(self, agents: npt.NDArray[np.int64], seeds: npt.NDArray[np.uint64]) -> None:
        """Begin anew with some of the agents, in the worlds of new seeds, counters at zero.

        Args:
            agents: which: (k,).
            seeds: their new worlds: (k,).

        Raises:
            WorldError: seeds of another shape or type.
        """
        if len(agents) == 0:
            return
        check_seeds(seeds)
        state = self.params.agents.state
        for i, seed in zip(agents.tolist(), seeds.tolist(), strict=True):
            row = int(state["world"][i])
            state[i] = np.zeros((), state.dtype)
            state["world"][i], state["seed"][i] = row, seed
            if not isinstance(self.world, World):
                self._write_world(row, seed)
        for run in np.split(agents, np.flatnonzero(np.diff(agents) != 1) + 1):
            self._put(int(run[0]), int(run[-1]) + 1)

    def distances(self) -> npt.NDArray[np.float32]:
        """What each sub-ray of the first agent's first eye would meet now: as `bearings_rad`, m.

        The range where it would meet nothing. No look: nothing is remembered, nothing disturbed.
        """
        held, eye = self._new_held(self._motions), self.params.eye
        call_cast(cast_for(self.params, self._motions), held)
        self.require_nothing_lost(held)
        distance_m: npt.NDArray[np.float32] = held.value.work.distance_m
        return distance_m[: eye.rays * eye.samples]

    def outlines_near(self, agent: int) -> list[Outline]:
        """Obstacles near an agent, where it sees them (y may leave the period), for drawing.

        Everything within the eye's reach is there, and some of what lies just beyond it.
        """
        return outlines_near(self.params, agent)

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
            check_same_form(name, state.get(name), array)
        for name, array in mine.items():
            array[...] = state[name]
        if not isinstance(self.world, World):
            for row, seed in enumerate(self.params.agents.state["seed"].tolist()):
                self._write_world(row, seed)

    def _write_world(self, row: int, seed: int) -> None:
        """Let the world of a seed take a row of the tables."""
        tables, world = self.params.world, self.world.drawn(seed)
        write_world(tables, row, world, self.contract, all_round=self.all_round)
