"""A pilot forgets what it held and remembered where an agent was put somewhere else, once."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import PolicyError, UsageError
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.reference_field import measure

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


class Saying:
    """Always stays, and says these Q-values beside."""

    def __init__(self, *q_values: float) -> None:
        self._said = np.array(q_values, np.float32)

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        said = np.zeros((len(retinas), len(self._said)), np.float32)
        said[-1] = self._said  # of one agent only
        return said, np.zeros(len(retinas), np.int64)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_a_robot_stops_for_is_not_measured_as_if_it_drove(value: float) -> None:
    """The action beside it is valid; a robot's controller says POLICY_FAULT all the same."""
    said = rf"Q-values: expected finite numbers, got {value} for 1 of 2 agents at step 0"
    with pytest.raises(PolicyError, match=said):
        Pilot(Saying(0.0, value, 0.0), PolicyContract(), 2, 0.1).act(TWO)
    with pytest.raises(UsageError, match="for 1 of 8 agents"):
        measure(Saying(value, 0.0, 0.0), PolicyContract(), agents=8, steps=2, discard=0)


def test_another_number_of_q_values_is_refused() -> None:
    with pytest.raises(PolicyError, match=r"expected the shape \(2, 3\), got \(2, 2\)"):
        Pilot(Saying(0.0, 0.0), PolicyContract(), 2, 0.1).act(TWO)


def test_a_memory_that_is_no_number_is_refused() -> None:
    class Forgetting(Counting):
        def decide(
            self, retinas: RetinaBatch, memories: Memories
        ) -> tuple[QValues, Actions, Memories]:
            q_values, winners, _ = super().decide(retinas, memories)
            return q_values, winners, np.full_like(memories, np.nan)

    pilot = Pilot(Forgetting(), replace(PolicyContract(), state=StateSpec(1)), 2, 0.1)
    with pytest.raises(PolicyError, match="memory: expected finite numbers, got nan for 2 of 2"):
        pilot.act(TWO)
