"""Chooses the actions of many simulated agents as a robot's controller would: with holds, margins
and memories, and behind a guard where there is one.

Every look of an agent is a good and fresh input, so the verdicts of a robot do not occur here. One
could: a robot whose policy computes a NaN or an infinity stops, with the verdict `POLICY_FAULT`.
Such a policy is refused here, whatever action it names beside.
"""

from typing import TYPE_CHECKING, cast

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, Mask, QValues, RetinaBatch
from reflexarc_runtime.choice import outweighs, slots_of
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_sim_bridge.evaluation.driving.crowd_guard import CrowdGuard
from reflexarc_sim_bridge.simulation.simulation import Simulation

if TYPE_CHECKING:
    from reflexarc_runtime.policy.policy import Policy, RememberingPolicy


class Pilot:
    """A policy, and what it remembers and holds for each agent.

    Args:
        policy: decides for all agents at once.
        contract: its holds, margin and memory.
        agents: how many.
        period_s: time between two decisions: a hold has the same length in seconds at any rate.
        guard: lets only pass what is free; the simulation then moves by its contract.
    """

    def __init__(
        self,
        policy: "Policy | RememberingPolicy",
        contract: PolicyContract,
        agents: int,
        period_s: float,
        guard: CrowdGuard | None = None,
    ) -> None:
        self._policy = policy
        self._contract = contract
        self._memories = start_of(contract, agents)
        self._hold_slots = slots_of(contract.hold_s, 1.0 / period_s)
        self._slot = 0
        self._held: Actions | None = None
        self._guard = guard
        self.wanted: Actions = np.zeros(agents, np.int64)
        """Rows of the policy's contract: what it chose last, whatever a guard made of it."""
        self._is_free: Mask = np.zeros(agents, np.bool_)
        self._since: npt.NDArray[np.int64] = np.zeros(agents, np.int64)

    def act(self, stacks: RetinaBatch) -> Actions:
        """What each agent does now: (agents,), of (agents, frames, eyes, rays, channels).

        With a guard these are rows of its contract's actions, not of the policy's.

        Raises:
            PolicyError: Q-values or memories that are no finite numbers, or of another shape.
        """
        q_values, winners = self._decide(stacks)
        self._require_sound(q_values)
        actions = self._choose(q_values, winners) if self._chooses else winners
        self.wanted = actions
        if self._guard is not None:
            wanted = actions
            actions = self._guard.act(stacks, wanted, q_values)
            self._let_go(actions != wanted)
        self._slot += 1
        return actions

    def drive(self, simulation: Simulation) -> Actions:
        """See `Driver`."""
        return self.act(simulation.stacks)

    def begin_anew(self, agents: Mask) -> None:
        """Forget what these agents remember and hold, (agents,): they were put somewhere else.

        Only a simulation does that. What a robot remembers is of the place where it is.
        """
        fresh = start_of(self._contract, len(agents))
        if self._memories is not None and fresh is not None:
            self._memories = np.where(agents[:, np.newaxis], fresh, self._memories)
        self._let_go(agents | self._is_free)

    def _let_go(self, ended: Mask) -> None:
        """Let go what is held by the agents whose guard stepped in: they begin with a winner."""
        if self._held is not None:
            self._is_free = ended

    @property
    def _chooses(self) -> bool:
        """Whether another action than the winner may be done."""
        contract = self._contract
        return self._hold_slots > 1 or contract.margin > 0.0 or contract.least_lead > 0.0

    def _decide(self, stacks: RetinaBatch) -> tuple[QValues, Actions]:
        if self._memories is None:
            return cast("Policy", self._policy).decide(stacks)
        remembering = cast("RememberingPolicy", self._policy)
        q_values, winners, self._memories = remembering.decide(stacks, self._memories)
        return q_values, winners

    def _require_sound(self, q_values: QValues) -> None:
        """Refuse what a robot would stop for."""
        shape = (len(self.wanted), len(self._contract.actions))
        if np.shape(q_values) != shape:
            raise PolicyError(f"Q-values: expected the shape {shape}, got {np.shape(q_values)}")
        memories = () if self._memories is None else (self._memories,)
        for name, values in (("Q-values", q_values), *(("memory", each) for each in memories)):
            sound = np.isfinite(values)
            if not sound.all():
                agents = int((~sound.all(axis=1)).sum())
                got = f"{np.asarray(values)[~sound][0]} for {agents} of {shape[0]} agents"
                wrong = f"{name}: expected finite numbers, got {got} at step {self._slot}"
                raise PolicyError(f"{wrong}; a robot stops there")

    def _choose(self, q_values: QValues, winners: Actions) -> Actions:
        """`reflexarc_runtime.choice.choose`, for all agents at once."""
        if self._held is None:
            self._held = winners.copy()
            return self._held
        stays = self._stays(q_values.astype(np.float64), winners, self._held) & ~self._is_free
        self._is_free = np.zeros_like(self._is_free)
        self._held = np.where(stays, self._held, winners)
        self._since = np.where(stays, self._since, self._slot)
        return self._held

    def _stays(self, q_values: npt.NDArray[np.float64], winners: Actions, held: Actions) -> Mask:
        rows = np.arange(len(winners))
        lead = q_values[rows, winners] - q_values[rows, held]
        spread, contract = np.ptp(q_values, axis=1), self._contract
        wins: Mask = outweighs(lead, spread, contract.margin, contract.least_lead)
        is_held: Mask = (winners == held) | (self._slot - self._since < self._hold_slots)
        return is_held | ~wins
