import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.track import Track
from support.hand_tracks import figures, marks, path_of

STEPS = 600


def always_left(radius_m: float = 0.4, met_at: tuple[int, ...] = ()) -> Track:
    angle = 0.1 / radius_m * np.arange(STEPS)
    y_m = 10.0 + radius_m * (1.0 - np.cos(angle))
    return path_of(radius_m * np.sin(angle), y_m, met=marks(STEPS, *met_at))


def straight(met_at: tuple[int, ...]) -> Track:
    return path_of(0.1 * np.arange(STEPS), np.full(STEPS, 10.0), met=marks(STEPS, *met_at))


def windows_without_contact_m(track: Track, window: int) -> float:
    """Contacts per 100 m of net displacement, by windows that hold none: the figure that is not."""
    net_m, contacts = 0.0, 0.0
    for first in range(0, STEPS - window, window):
        last = first + window
        if track.met[first:last].any():
            contacts += track.met[first:last].sum()
        else:
            moved = track.x_m[last] - track.x_m[first], track.y_m[last] - track.y_m[first]
            net_m += float(np.hypot(*moved)[0])
    return 100.0 * contacts / net_m


def test_a_circle_gets_as_far_as_its_diameter() -> None:
    assert figures(always_left())["farthest_m"] == pytest.approx(0.8, abs=0.01)


def test_always_left_scores_below_who_never_steers() -> None:
    """Though it meets nothing for a minute, where the other one meets something every 3 m."""
    blind = straight(tuple(range(29, STEPS, 30)))
    circles = figures(always_left())
    assert figures(blind)["farthest_m"] == pytest.approx(2.9)
    assert circles["farthest_m"] < 1.0
    # Contacts per path, and per net displacement in windows, both fall for it.
    assert circles["contacts_per_100m"] == 0.0 < figures(blind)["contacts_per_100m"]
    assert windows_without_contact_m(always_left(), 20) == 0.0
    assert windows_without_contact_m(blind, 20) > 10.0


def test_the_greatest_distance_counts_and_not_the_last() -> None:
    there_and_back = np.concatenate([0.1 * np.arange(300), 0.1 * np.arange(300)[::-1]])
    found = figures(path_of(there_and_back, np.full(STEPS, 10.0)))
    assert found["farthest_m"] == pytest.approx(29.9)


def test_what_follows_the_first_contact_does_not_count() -> None:
    assert figures(straight((49,)))["farthest_m"] == pytest.approx(4.9)
    assert figures(straight((0,)))["farthest_m"] == 0.0


def test_across_the_seam_the_way_goes_on() -> None:
    y_m = np.mod(10.0 + 0.1 * np.arange(STEPS), 20.0)
    assert figures(path_of(np.zeros(STEPS), y_m))["farthest_m"] == pytest.approx(59.9)


def test_agents_are_averaged() -> None:
    both = figures(straight((49,)), straight((99,)))
    assert both["farthest_m"] == pytest.approx((4.9 + 9.9) / 2)
