"""How far turning bodies get, on tracks whose answer is known."""

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.greatest_distance import greatest_distance_m
from support.tracks import track_of


def test_straight_ahead_gets_as_far_as_it_went() -> None:
    x_m = 100.0 + np.arange(11)[:, np.newaxis] * 0.5
    assert greatest_distance_m(track_of(x_m, np.full_like(x_m, 3.0))) == pytest.approx([5.0])


def test_a_circle_gets_no_farther_than_its_diameter_however_long_it_lasts() -> None:
    angle = np.linspace(0.0, 20.0 * np.pi, 2001)[:, np.newaxis]
    track = track_of(1.5 * np.sin(angle), 10.0 + 1.5 * (1.0 - np.cos(angle)))
    assert greatest_distance_m(track) == pytest.approx([3.0], rel=1e-3)


def test_what_comes_after_the_first_contact_does_not_count() -> None:
    x_m = np.arange(6.0)[:, np.newaxis]
    met = np.zeros((6, 1), bool)
    met[2] = met[4] = True
    assert greatest_distance_m(track_of(x_m, np.zeros_like(x_m), met)) == pytest.approx([2.0])


def test_the_seam_of_a_periodic_world_is_no_wall() -> None:
    y_m = np.mod(19.0 + np.arange(31.0) * 0.5, 20.0)[:, np.newaxis]
    assert greatest_distance_m(track_of(np.zeros_like(y_m), y_m)) == pytest.approx([15.0])


def test_there_and_back_counts_the_turning_point() -> None:
    x_m = np.array([0.0, 1.0, 2.0, 1.0, 0.0, -0.5])[:, np.newaxis]
    assert greatest_distance_m(track_of(x_m, np.zeros_like(x_m))) == pytest.approx([2.0])
