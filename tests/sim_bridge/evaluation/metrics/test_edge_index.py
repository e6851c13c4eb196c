"""The edge index, by hand and on agents whose places are known."""

import numpy as np
import pytest

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.metrics.edge_index import (
    edge_index,
    obstacle_radius_m,
    require_edge_index,
)
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.world import World
from reflexarc_trainer.study.measuring import measure_edge_index
from reflexarc_trainer.study.unit import Evaluation


class AlwaysLeft:
    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        n = len(retinas)
        return np.zeros((n, 3), np.float32), np.ones(n, np.int64)


def shipped(name: str) -> World:
    world = world_named(name)
    assert isinstance(world, World)
    return world


def test_even_places_have_an_index_of_one() -> None:
    places_m = (np.arange(12_000) + 0.5) / 1000.0
    assert edge_index(places_m, 12.0, 0.5) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("places_m", "index"),
    [
        ([0.1, 11.9], 6.0),  # always there: W/4R = 12/2
        ([6.0, 7.0], 0.0),
        ([0.5, 6.0, 6.0, 6.0], 1.5),  # a quarter of the time, where a sixth is even
        ([0.999, 11.001, 1.001, 10.999], 3.0),  # the bands end at 1 m from either side
    ],
)
def test_index_is_the_share_of_the_time_near_a_side_over_the_even_one(
    places_m: list[float], index: float
) -> None:
    assert edge_index(np.array(places_m), 12.0, 0.5) == pytest.approx(index)


def test_radius_is_half_the_mean_width_of_obstacles_and_the_agents_own() -> None:
    assert obstacle_radius_m(shipped("legacy")) == pytest.approx(0.5)
    assert obstacle_radius_m(shipped("reference-1")) == pytest.approx(0.45)
    assert obstacle_radius_m(shipped("rover")) > shipped("rover").chassis.radius_m


def test_agent_that_always_goes_left_lives_at_the_left_side_of_an_open_world() -> None:
    index = measure_edge_index(
        AlwaysLeft(), PolicyContract(), shipped("legacy"), Evaluation(32, 200, 120)
    )
    assert 4.5 < index <= 6.0  # contacts put it anywhere else now and then


def test_agent_that_never_steers_is_anywhere_alike_in_a_periodic_world() -> None:
    index = measure_edge_index(
        BlindPolicy(), PolicyContract(), shipped("reference-1"), Evaluation(256, 300, 0)
    )
    assert index == pytest.approx(1.0, abs=0.15)  # 2,800 places: one standard error is 0.06


@pytest.mark.parametrize("name", ["corridor-20", "gates", "randomised", "plane"])
def test_worlds_without_sides_or_seam_are_refused_in_one_line(name: str) -> None:
    with pytest.raises(UsageError, match="for its edges"):
        require_edge_index(world_named(name))
