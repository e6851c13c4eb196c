import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.threats import threats, threats_of
from support.hand_tracks import SIDEWAYS, TURNING, figures, marks, track_of


def approach(steps: int, at: int) -> np.ndarray:
    """Time to an obstacle that is met at the end of step `at`, and nothing behind it."""
    ahead_s = 0.1 * (at + 1 - np.arange(steps, dtype=np.float64))
    return np.where(ahead_s > 0.0, ahead_s, np.inf)


def test_who_never_steers_avoids_nothing() -> None:
    found = figures(track_of(60, met=marks(60, 39), ahead_s=approach(60, 39)))
    assert found["threat_avoidance"] == 0.0
    assert found["least_ahead_s"] == 0.0
    assert found["reacts"] == 0.0
    assert math.isnan(found["reaction_m"])
    # Below T_h = 2 · 0.5 s from 0.9 s on: nine steps of sixty.
    assert found["threatened"] == pytest.approx(9 / 60)
    assert found["within_1s"] == pytest.approx(9 / 60)


def test_a_threat_that_is_steered_away_from_is_avoided() -> None:
    ahead_s = approach(60, 39)
    ahead_s[36:] = np.inf
    actions = np.where(np.arange(60) >= 34, 1, 0)
    found = figures(track_of(60, ahead_s=ahead_s, actions=actions))
    assert found["threat_avoidance"] == 1.0
    assert found["least_ahead_s"] == pytest.approx(0.5)  # step 35
    # It leaves "stay" at step 34, 0.6 s and 0.6 m before; R/w is 0.5 s.
    assert (found["reacts"], found["reaction_m"]) == (1.0, pytest.approx(0.6))
    assert found["reaction_limits"] == pytest.approx(1.2)


def test_a_collision_without_a_threat_is_one_that_was_not_avoided() -> None:
    ahead_s = np.full(60, np.inf)
    ahead_s[10:20] = 0.5
    found = figures(track_of(60, met=marks(60, 40), ahead_s=ahead_s))
    assert found["threat_avoidance"] == pytest.approx(0.5)


def test_a_contact_ends_a_threat_and_another_place_begins_another() -> None:
    track = track_of(20, met=marks(20, 4, 9), ahead_s=0.5)
    assert threats(track).tolist() == [2.0]
    assert threats_of(track).first.tolist() == [0, 5, 10]


def test_a_threat_that_the_end_cuts_off_counts_for_nothing() -> None:
    found = figures(track_of(20, ahead_s=np.where(np.arange(20) < 15, np.inf, 0.4)))
    assert math.isnan(found["threat_avoidance"])
    assert math.isnan(found["least_ahead_s"])


def test_without_threats_there_is_no_avoidance_and_no_exposure() -> None:
    found = figures(track_of(20))
    assert math.isnan(found["threat_avoidance"])
    assert (found["threatened"], found["within_1s"]) == (0.0, 0.0)


def test_threats_of_several_agents_stay_apart() -> None:
    ahead_s = np.full((20, 3), np.inf)
    ahead_s[15:, 0], ahead_s[:5, 1], ahead_s[8:9, 1] = 0.3, 0.7, 0.2
    track = track_of(20, 3, ahead_s=ahead_s)
    assert threats(track).tolist() == [0.0, 2.0, 0.0]
    assert figures(track)["least_ahead_s"] == pytest.approx((0.7 + 0.2) / 2)


def test_latency_and_slow_sidesteps_make_the_horizon_longer() -> None:
    assert SIDEWAYS.threat_s == pytest.approx(1.0)
    assert replace(SIDEWAYS, lateral_mps=0.25, latency_s=0.3).threat_s == pytest.approx(4.6)


def test_a_turner_is_out_of_the_way_where_its_circle_is_r_aside() -> None:
    # (v/ω)(1 − cos ωt) = R: cos t = 0.5 at v = ω = 1, R = 0.5.
    assert TURNING.dodge_s == pytest.approx(math.acos(0.5))
    assert replace(TURNING, obstacle_radius_m=3.0).dodge_s == pytest.approx(math.pi)
    assert replace(TURNING, angular_radps=0.0).dodge_s == math.inf
