"""The shortest way to one agent, against the simulation itself."""

import gc
from collections.abc import Iterator

import numpy as np
import pytest

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.single_agent import REFUSED, OneAgent
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract


def simulation() -> Simulation:
    return Simulation(world_named("reference-1"), reference_contract(), np.zeros(1, np.uint64))


@pytest.fixture
def actions() -> Iterator[int]:
    return iter(np.random.default_rng(0).integers(0, 3, 200).tolist())


def test_it_goes_where_the_simulation_goes(actions: Iterator[int]) -> None:
    one, other = OneAgent(simulation()), simulation()
    for action in actions:
        met, _, _, distance_m, contacts = one.step_and_sense(action)
        expected = other.step_and_sense(np.array([action]))
        assert met == expected[0]
        np.testing.assert_array_equal(one.stack, other.stacks[0].ravel())
    assert distance_m == other.distance_m[0]
    assert contacts == other.contacts[0]


def test_its_step_outlives_it() -> None:
    step = OneAgent(simulation()).step_and_sense
    gc.collect()
    assert step.args[0].kept is not None  # type: ignore[attr-defined]  # it is a partial
    assert step(0)[3] == pytest.approx(0.1)


def test_an_action_that_the_contract_has_not_is_refused() -> None:
    one = OneAgent(simulation())
    assert one.step_and_sense(3)[0] == REFUSED
    assert one.step_and_sense(-1)[0] == REFUSED
