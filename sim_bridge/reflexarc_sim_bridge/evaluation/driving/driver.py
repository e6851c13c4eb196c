"""Whoever chooses the actions of many simulated agents: by what they see, or by what it knows."""

from typing import Protocol

from reflexarc_runtime.arrays import Actions, Mask
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.simulation.simulation import Simulation


class Driver(Protocol):
    """Drives all agents of a simulation, step by step."""

    wanted: Actions
    """Rows of the contender's contract: what it chose last."""

    def drive(self, simulation: Simulation) -> Actions:
        """What each agent does now, after its look: (agents,)."""

    def begin_anew(self, agents: Mask) -> None:
        """Forget what is known of these agents, (agents,): they were put somewhere else."""


class Knower(Protocol):
    """In place of a policy: drives by what it knows of a simulation, not by what its agents see."""

    def driver(self, simulation: Simulation, contract: PolicyContract) -> Driver:
        """Who drives the agents of this simulation."""
