"""A simulated robot in a world, with a watchdog of its own. It uses neither bus nor clock."""

from dataclasses import dataclass, replace

import numpy as np

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Command
from reflexarc_runtime.loop.watchdog import Watchdog
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.world import World


@dataclass(frozen=True, slots=True)
class BodyPose:
    """Position and heading of the robot, in the world's frame."""

    x_m: float
    y_m: float
    heading_rad: float = 0.0
    """Counter-clockwise from x; 0 for a robot that only moves sideways."""


class Body:
    """A robot with the eye of a contract, which moves by the commands that it gets.

    Args:
        world: the world that it drives in.
        contract: its eye, its fastest motions, and its safe command.
        rate_hz: steps of the simulation a second.
        seed: of the world.
        number: which of several robots in one world; each has places of its own.

    Raises:
        WorldError: the contract asks for a sense or a motion that the world does not have.
    """

    def __init__(
        self,
        world: World,
        contract: PolicyContract,
        rate_hz: float,
        seed: int,
        number: int = 0,
    ) -> None:
        self.contract = contract
        self.simulation = Simulation(
            replace(world, dt_s=1.0 / rate_hz),
            contract,
            np.array([seed], np.uint64),
            lanes=np.array([number], np.uint64),
        )
        self.contacts = 0
        self._watchdog = Watchdog(contract.safe_command)

    def hear(self, command: Command) -> None:
        """Take a command; the newest counts."""
        self._watchdog = self._watchdog.heard(command)

    def move(self, now_ns: int) -> BodyPose | None:
        """Move for one period by the command that still holds, else by the safe command.

        Returns:
            Where a collision began, to within the sideways motion of one step; None without a
            collision. After one the robot stands elsewhere.
        """
        before = self.place
        command = self._watchdog.obeyed(now_ns)
        # A safe command that was received never expires, so its speeds are not used: the body moves
        # by the safe command of its own contract.
        drives = command is not None and not command.is_safe and self._can_move_so(command)
        motion = command if command is not None and drives else self.contract.safe_command
        if not self.simulation.drive(motion.linear_mps, motion.lateral_mps, motion.angular_radps):
            return None
        self.contacts += 1
        return replace(before, x_m=self.place.x_m)

    def _can_move_so(self, command: Command) -> bool:
        """Whether no speed exceeds those of the contract's actions; else it is not obeyed."""
        return all(
            abs(getattr(command, speed))
            <= max(abs(getattr(a, speed)) for a in self.contract.actions)
            for speed in ("linear_mps", "lateral_mps", "angular_radps")
        )

    def see(self) -> Retina:
        """The retina now: uint8 (eyes, rays, channels)."""
        retina: Retina = self.simulation.sense()[0]
        return retina

    @property
    def place(self) -> BodyPose:
        """Its position and heading now."""
        here = self.simulation
        return BodyPose(float(here.x_m[0]), float(here.y_m[0]), float(here.heading_rad[0]))
