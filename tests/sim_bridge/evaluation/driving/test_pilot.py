"""A pilot forgets what it held and remembered where an agent was put somewhere else, once."""

from dataclasses import replace

import numpy as np

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot

TWO = np.zeros((2, 1, 1, 16, 1), np.uint8)


class Alternating:
    """Wants left at even calls, right at odd ones."""

    calls = 0

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        self.calls += 1
        winners = np.full(len(retinas), 1 + self.calls % 2)
        return np.eye(3, dtype=np.float32)[winners], winners


class Counting:
    """Remembers how often it was asked."""

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        n = len(retinas)
        return np.zeros((n, 3), np.float32), np.zeros(n, np.int64), memories + np.float32(1.0)


def test_a_new_place_ends_a_hold_once_and_of_that_agent_alone() -> None:
    contract = replace(PolicyContract(), hold_s=1.0)
    pilot = Pilot(Alternating(), contract, 2, 0.1)
    done = [pilot.act(TWO).tolist()]
    pilot.begin_anew(np.array([True, False]))
    done += [pilot.act(TWO).tolist() for _ in range(3)]
    assert done == [[2, 2], [1, 2], [1, 2], [1, 2]]


def test_a_new_place_clears_the_memory_of_that_agent_alone() -> None:
    contract = replace(PolicyContract(), state=StateSpec(1, (5.0,)))
    asked: list[list[float]] = []

    class Spy(Counting):
        def decide(
            self, retinas: RetinaBatch, memories: Memories
        ) -> tuple[QValues, Actions, Memories]:
            asked.append(memories[:, 0].tolist())
            return super().decide(retinas, memories)

    pilot = Pilot(Spy(), contract, 2, 0.1)
    pilot.act(TWO)
    pilot.begin_anew(np.array([False, True]))
    pilot.act(TWO)
    assert asked == [[5.0, 5.0], [6.0, 5.0]]
