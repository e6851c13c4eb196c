import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.edge_index import edge_index
from reflexarc_sim_bridge.evaluation.metrics.lateral import divergence_bits, mirror_bits
from support.hand_tracks import SIDEWAYS, figures, track_of


def test_the_edge_index_is_that_of_all_places_together() -> None:
    y_m = 20.0 * np.random.default_rng(3).beta(0.5, 0.5, 5000)
    found = figures(track_of(5000, y_m=y_m))["edge_index"]
    assert found == pytest.approx(edge_index(y_m, 20.0, 0.5))


@pytest.mark.parametrize(("place_m", "index"), [(0.5, 10.0), (10.0, 0.0)])
def test_always_at_a_side_it_is_w_over_4r_and_in_the_middle_0(place_m: float, index: float) -> None:
    assert figures(track_of(30, y_m=np.full(30, place_m)))["edge_index"] == pytest.approx(index)


def test_an_unbounded_or_a_narrow_world_has_none() -> None:
    unbounded = track_of(30, 1, replace(SIDEWAYS, has_sides=False), y_m=-300.0 + np.arange(30))
    found = figures(unbounded)
    assert math.isnan(found["edge_index"])
    assert math.isnan(found["place_divergence"])
    assert math.isnan(found["mirror_places"])
    assert math.isnan(figures(track_of(30, 1, replace(SIDEWAYS, width_m=2.0)))["edge_index"])


def test_divergence_is_0_of_uniform_places_and_log_n_of_a_single_one() -> None:
    everywhere = figures(track_of(2000, y_m=0.01 * np.arange(2000)))
    assert everywhere["place_divergence"] == pytest.approx(0.0, abs=1e-9)
    assert figures(track_of(9))["place_divergence"] == pytest.approx(math.log2(20))
    assert divergence_bits(np.array([3.0, 1.0])) == pytest.approx(1.0 - 0.8112781)


def test_mirror_divergence_is_0_of_the_symmetric_and_1_bit_of_the_one_sided() -> None:
    assert mirror_bits(np.array([3.0, 1.0, 1.0, 3.0])) == pytest.approx(0.0)
    assert mirror_bits(np.array([5.0, 0.0, 0.0])) == pytest.approx(1.0)
    always_left = figures(track_of(40, actions=np.ones(40)))
    assert always_left["mirror_actions"] == pytest.approx(1.0)
    both = figures(track_of(40, actions=1 + np.arange(40) % 2))
    assert both["mirror_actions"] == pytest.approx(0.0)


def test_mirror_divergence_is_jensen_and_shannons() -> None:
    p = np.array([0.5, 0.2, 0.2, 0.1])
    q, middle = p[::-1], (p + p[::-1]) / 2
    expected = (p * np.log2(p / middle)).sum() / 2 + (q * np.log2(q / middle)).sum() / 2
    assert mirror_bits(p) == pytest.approx(expected)
