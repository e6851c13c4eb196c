"""What a policy would have done that only watches: a shadow of the one that decides.

It is given what the other one was given, tick by tick, and has a memory and held actions of its
own. Both begin anew where it missed a tick, where the loop asked no policy, and after a fault: so
what it says follows from the ticks that it was given, and replays.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.arrays import Memories, QValues
from reflexarc_runtime.choice import Hold, choose
from reflexarc_runtime.decision import NO_WINNER, SAFE_ACTION
from reflexarc_runtime.policy.policy import LoadedPolicy


@dataclass(frozen=True, slots=True)
class ShadowTick:
    """A tick at which the policy that decides was asked."""

    index: int
    slot: int
    retina: bytes
    """All that it was given."""
    drove: int
    """What it preferred."""
    begins: bool
    """Whether the shadow was not given the tick before."""
    is_newer: bool
    """Whether the input is another one than at the tick before."""


class ShadowMind:
    """A policy that watches, and what it remembers.

    Args:
        policy: who would have decided.
    """

    def __init__(self, policy: LoadedPolicy) -> None:
        self._policy = policy
        self._memory: Memories | None = None
        self._following: Memories | None = None
        self._hold: Hold | None = None
        self._begin()

    def decide(self, tick: ShadowTick) -> pb.Shadow:
        """What it would have done at the next tick; never raises."""
        if tick.begins:
            self._begin()
        elif tick.is_newer:
            self._memory = self._following
        said = pb.Shadow(
            index=tick.index,
            policy_hash=self._policy.policy_hash,
            drove=tick.drove,
            begins=tick.begins,
            is_newer=tick.is_newer,
        )
        try:
            q_values, winner = self._asked(tick.retina)
        except Exception as error:  # whatever a policy does
            return self._failed(said, type(error).__name__)
        values = q_values.tolist()
        is_action = 0 <= winner < len(self._policy.contract.actions)
        if not (is_action and all(map(math.isfinite, values)) and self._remembers_numbers()):
            return self._failed(said, "values not finite, or no such action")
        said.q_values[:] = values
        said.winner, said.action = winner, self._done(values, winner, tick.slot)
        if 0 <= tick.drove < len(values):
            said.lead = values[winner] - values[tick.drove]
        return said

    def _asked(self, retina: bytes) -> tuple[QValues, int]:
        contract = self._policy.contract
        stack = np.frombuffer(retina, np.uint8).reshape(1, *contract.retina.stack_shape)
        if self._memory is None:
            q_values, winners = self._policy.decide(stack)
        else:
            q_values, winners, self._following = self._policy.decide(stack, self._memory)
        return q_values[0], int(winners[0])

    def _done(self, values: list[float], winner: int, slot: int) -> int:
        contract = self._policy.contract
        least = contract.hold_slots, contract.margin, contract.least_lead
        self._hold = choose(self._hold, values, winner, slot, *least)
        return self._hold.action

    def _remembers_numbers(self) -> bool:
        return self._following is None or bool(np.isfinite(self._following).all())

    def _failed(self, said: pb.Shadow, why: str) -> pb.Shadow:
        self._begin()
        said.winner, said.action, said.fault = NO_WINNER, SAFE_ACTION, why
        return said

    def _begin(self) -> None:
        spec = self._policy.contract.state
        self._memory = np.array([spec.start_value], np.float32) if spec.size else None
        self._following, self._hold = self._memory, None
