import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_baselines.evolving.race import Farthest, race
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import training_seeds

SIDEWAYS = replace(reference_contract(), state=StateSpec(size=1))
SEEDS = training_seeds(64)


class Fixed:
    """Each genome always does one thing; a memory counts the decisions since it was cleared."""

    def __init__(self, *actions: int) -> None:
        self._actions = actions
        self.cleared = 0

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        self.cleared += int((memories == 0.0).sum())
        chosen = np.repeat(np.array(self._actions), len(retinas) // len(self._actions))
        return np.zeros((len(retinas), 3), np.float32), chosen, memories + np.float32(1.0)


def raced(crowd: Fixed, genomes: int, contract: PolicyContract = SIDEWAYS) -> list[float]:
    costs: list[float] = race(crowd, contract, "reference-1", genomes, SEEDS, 100).tolist()
    return costs


def test_a_body_that_never_steers_costs_what_the_density_of_the_field_says() -> None:
    """36 contacts per 100 m, and some 230 of them: ± 7 %."""
    assert raced(Fixed(0), 1)[0] == pytest.approx(36.0, rel=0.2)


def test_the_same_genome_costs_the_same_at_every_place_of_a_population() -> None:
    costs = raced(Fixed(0, 1, 0, 1), 4)
    assert costs[0] == costs[2] != costs[1] == costs[3]


def test_memories_are_cleared_at_the_start_and_after_each_contact() -> None:
    """Contacts = cost · progress; those of the last step clear nothing that is read again."""
    crowd = Fixed(0)
    contacts = raced(crowd, 1)[0] / 100.0 * 64 * 10.0
    assert crowd.cleared - 64 == pytest.approx(contacts, abs=12)


def test_a_turning_body_costs_minus_the_greatest_distance_that_it_reached() -> None:
    """Round a circle of radius 0.05 m it gets 0.1 m away, unless it met something before."""
    turning = (Action("stay", 0.0, 0.0), Action("round", 0.1, 0.0, 2.0))
    costs = raced(Fixed(0, 1), 2, replace(SIDEWAYS, actions=turning))
    assert costs[0] == 0.0
    assert -0.1 <= costs[1] < -0.08


def test_the_greatest_distance_goes_over_the_seam_and_ends_at_a_contact() -> None:
    farthest = Farthest(2, width_m=20.0)
    y_m = [19.0, 19.9, 0.8, 1.7]
    for step, y in enumerate(y_m):
        farthest.see(np.array([0.3 * step] * 2), np.array([y, y]))
        if step == 1:
            farthest.meet(np.array([False, True]))
    assert farthest.distance_m[0] == pytest.approx(math.hypot(0.9, 2.7))
    assert farthest.distance_m[1] == pytest.approx(math.hypot(0.3, 0.9))


def test_who_comes_back_has_been_away() -> None:
    farthest = Farthest(1, width_m=20.0)
    for x in (0.0, 2.0, 0.5):
        farthest.see(np.array([x]), np.array([5.0]))
    assert farthest.distance_m.tolist() == [2.0]
