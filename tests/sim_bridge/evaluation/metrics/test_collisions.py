from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.collisions import contacts, onsets
from support.hand_tracks import SIDEWAYS, figures, marks, path_of, track_of

GHOSTS = replace(SIDEWAYS, respawns=False)


def test_contacts_by_way_and_by_mean_free_path() -> None:
    # 100 steps of 0.1 m: 10 m, 5 mean free paths; 2 contacts.
    found = figures(track_of(100, met=marks(100, 10, 50)))
    assert found["contacts_per_100m"] == pytest.approx(20.0)
    assert found["contacts_per_free_path"] == pytest.approx(0.4)


def test_who_is_put_elsewhere_collides_anew_at_every_contact() -> None:
    assert contacts(track_of(10, met=marks(10, 3, 4, 5))).tolist() == [3.0]


@pytest.mark.parametrize(("clear_steps", "counted"), [(4, 1), (5, 2), (20, 2)])
def test_a_ghost_is_armed_after_half_a_second_in_the_clear(clear_steps: int, counted: int) -> None:
    clearance_m = np.full(40, 0.0)
    clearance_m[4 : 4 + clear_steps] = 0.05  # 0.1 R
    track = track_of(40, 1, GHOSTS, met=marks(40, 3, 3 + clear_steps), clearance_m=clearance_m)
    assert contacts(track).tolist() == [float(counted)]


def test_a_ghost_that_is_less_than_a_tenth_of_r_away_is_not_armed() -> None:
    track = track_of(40, 1, GHOSTS, met=marks(40, 3, 30), clearance_m=0.049)
    assert onsets(track)[:, 0].nonzero()[0].tolist() == [3]


def test_a_ghost_is_armed_at_the_start() -> None:
    track = track_of(3, 1, GHOSTS, met=marks(3, 0), clearance_m=0.0)
    assert contacts(track).tolist() == [1.0]


def test_the_way_of_a_turner_is_the_length_of_its_path() -> None:
    angle = 0.1 * np.arange(200)
    found = figures(path_of(np.sin(angle), 10.0 - np.cos(angle), met=marks(200, 199)))
    chord_m = 2.0 * np.sin(0.05)
    assert found["contacts_per_100m"] == pytest.approx(100.0 / (199 * chord_m))


def test_who_stands_has_no_rate() -> None:
    found = figures(track_of(10, x_m=0.0 * np.arange(10), progress_m=0.0 * np.arange(10)))
    assert np.isnan(found["contacts_per_100m"])
    assert np.isnan(found["contacts_per_free_path"])
