"""Chatter is counted as worked out by hand, and so are the frontier and its knee."""

from dataclasses import replace

import chatter
import numpy as np
import pytest
from chatter import Chatter

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


class InTurn:
    """Winners one after another, the same for all agents; each leads by 1 in Q."""

    def __init__(self, *winners: int) -> None:
        self.winners, self.asked = winners, 0

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy.decide`."""
        winner = self.winners[self.asked % len(self.winners)]
        self.asked += 1
        q_values = np.zeros((len(retinas), 3), np.float32)
        q_values[:, winner] = 1.0
        return q_values, np.full(len(retinas), winner)


def point(switches_hz: float, contacts: float) -> Chatter:
    return Chatter(0.0, 0.0, 0.0, contacts, switches_hz, 0.0, 0.0)


@pytest.mark.parametrize(
    ("winners", "changes", "switches_hz", "reversals_hz", "one_tick"),
    [
        ((1,), {}, 0.0, 0.0, 0.0),
        ((1, 2), {}, 50.0, 50.0, 1.0),  # left, right, left, …
        ((1, 0, 2, 0), {}, 50.0, 25.0, 1.0),  # straight on between them: a reversal all the same
        ((1, 1, 0, 0), {}, 25.0, 0.0, 0.0),
        ((1, 1, 2, 2), {"least_lead": 0.9}, 25.0, 25.0, 0.0),
    ],
)
def test_switches_are_counted_as_by_hand(
    winners: tuple[int, ...],
    changes: dict[str, float],
    switches_hz: float,
    reversals_hz: float,
    one_tick: float,
) -> None:
    contract = replace(reference_contract(), **changes)  # type: ignore[arg-type]  # numbers
    found = chatter.chatter(InTurn(*winners), contract, 50.0, agents=2, seconds=4.0)
    assert found.switches_hz == pytest.approx(switches_hz, rel=0.02)
    assert found.reversals_hz == pytest.approx(reversals_hz, rel=0.02)
    assert found.one_tick == pytest.approx(one_tick)


def test_of_the_frontier_nothing_is_better_in_both() -> None:
    found = [point(6.0, 2.0), point(3.0, 2.1), point(4.0, 2.2), point(1.0, 3.0), point(1.5, 3.0)]
    assert chatter.frontier(found) == [found[0], found[1], found[3]]


def test_the_knee_has_the_fewest_switches_of_those_within_5_percent() -> None:
    free = point(6.0, 2.0)
    found = [point(3.0, 2.05), point(2.0, 2.1), point(1.0, 2.11)]
    assert chatter.knee(found, free) is found[1]
    assert chatter.knee(found[2:], free) is free


def test_a_mean_is_that_of_each_column() -> None:
    assert chatter.mean([point(1.0, 2.0), point(2.0, 4.0)]) == point(1.5, 3.0)
