import math

import numpy as np
import pytest

from support.hand_tracks import figures, marks, path_of, track_of


def test_who_zigzags_goes_aside_as_far_as_ahead() -> None:
    y_m = 10.0 + 0.1 * (np.arange(101) % 2)
    found = figures(track_of(101, y_m=y_m))
    assert found["aside_per_ahead"] == pytest.approx(1.0)
    assert math.isnan(found["curvature"])
    assert math.isnan(found["smoothness"])


def test_a_seam_and_a_new_place_are_no_way_aside() -> None:
    y_m = np.mod(19.95 + 0.1 * np.arange(20), 20.0)  # across the seam at once
    assert figures(track_of(20, y_m=y_m))["aside_per_ahead"] == pytest.approx(1.0)
    y_m = np.where(np.arange(20) < 10, 3.0, 15.0)
    assert figures(track_of(20, y_m=y_m, met=marks(20, 9)))["aside_per_ahead"] == 0.0


@pytest.mark.parametrize("rate_radps", [0.5, 1.0, 2.0])
def test_on_a_circle_curvature_is_one_over_its_radius_and_jerk_that_of_the_formula(
    rate_radps: float,
) -> None:
    angle, radius_m = rate_radps * 0.1 * np.arange(400), 1.0 / rate_radps
    found = figures(path_of(radius_m * np.sin(angle), 10.0 - radius_m * np.cos(angle)))
    assert found["curvature"] == pytest.approx(rate_radps, rel=0.01)
    assert found["smoothness"] == pytest.approx(-4.0 * math.log(rate_radps), abs=0.03)
    assert math.isnan(found["aside_per_ahead"])


def test_a_straight_path_has_no_curvature_and_next_to_no_jerk() -> None:
    found = figures(path_of(0.1 * np.arange(50), np.full(50, 10.0)))
    assert found["curvature"] == 0.0
    assert found["smoothness"] > 25.0


def test_too_few_steps_have_no_jerk() -> None:
    assert math.isnan(figures(path_of(0.1 * np.arange(3), np.full(3, 10.0)))["smoothness"])


def test_a_new_place_is_no_jerk() -> None:
    x_m, y_m = 0.1 * np.arange(50), np.where(np.arange(50) < 20, 3.0, 15.0)
    found = figures(path_of(x_m, y_m, heading_rad=np.zeros(50), met=marks(50, 19)))
    assert found["smoothness"] > 25.0
