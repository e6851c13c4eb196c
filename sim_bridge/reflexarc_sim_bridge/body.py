"""The body: one robot in a world, with its own watchdog. It knows no bus and no clock."""

from dataclasses import dataclass, replace

import numpy as np

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.decision import Command
from reflexarc_runtime.watchdog import Watchdog
from reflexarc_sim_bridge import kernel
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import World


@dataclass(frozen=True, slots=True)
class Place:
    """Where the robot stands, in the world's frame; it always looks along x."""

    x_m: float
    y_m: float


class Body:
    """A robot that sees as the contract says and moves as it is told.

    Args:
        world: where it lives.
        contract: what it sees, and what it does when nobody tells it anything.
        rate_hz: how often it moves a second.
        seed: which of the world's endless variants this is.

    Raises:
        WorldError: the contract asks for a sense or a motion that the world does not have.
    """

    def __init__(self, world: World, contract: PolicyContract, rate_hz: float, seed: int) -> None:
        self.contract = contract
        self.simulation = Simulation(
            replace(world, dt_s=1.0 / rate_hz), contract, np.array([seed], np.uint64)
        )
        self.contacts = 0
        self._watchdog = Watchdog(contract.safe_command)

    def hear(self, command: Command) -> None:
        """Take a command; the newest counts."""
        self._watchdog = self._watchdog.heard(command)

    def move(self, now_ns: int) -> Place | None:
        """Move for one period by the command that still holds, or do the safe thing.

        Returns:
            Where a collision began, or None.
        """
        command = self._watchdog.obeyed(now_ns)
        # The safe thing is this body's own: a command without an echo moves nothing, whatever
        # speeds it names, for it would hold for ever.
        drives = command is not None and not command.is_safe and self._can_move_so(command)
        motion = command if command is not None and drives else self.contract.safe_command
        world, _, agents = self.simulation.params
        if not kernel.step_agent(world, agents, 0, motion.linear_mps, motion.lateral_mps):
            return None
        self.contacts += 1
        return self.place

    def _can_move_so(self, command: Command) -> bool:
        """Whether it is no faster than the contract's fastest actions: nobody else is obeyed."""
        actions = self.contract.actions
        forward_mps = max(abs(action.linear_mps) for action in actions)
        aside_mps = max(abs(action.lateral_mps) for action in actions)
        return abs(command.linear_mps) <= forward_mps and abs(command.lateral_mps) <= aside_mps

    def see(self) -> Retina:
        """The retina now: uint8 (eyes, rays, channels)."""
        retina: Retina = self.simulation.sense()[0]
        return retina

    @property
    def place(self) -> Place:
        """Where it stands."""
        return Place(float(self.simulation.x_m[0]), float(self.simulation.y_m[0]))
