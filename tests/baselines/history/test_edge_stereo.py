"""Depths from two eyes, against views of strips that are drawn here exactly, ray by ray."""

import math

import numpy as np
import pytest

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.history.edge_stereo import Depths, depth_m, edges_in, match
from support.strip_views import BASELINE_M, FOV_RAD, view


def depths_of(strips: list[tuple[float, float, float]], *, swapped: bool = False) -> Depths:
    eyes_m = (BASELINE_M / 2, -BASELINE_M / 2)
    views = [view(strips, y_m) for y_m in (eyes_m[::-1] if swapped else eyes_m)]
    left, right = (edges_in(lit, FOV_RAD, 0.1) for lit in views)
    return match(left, right, BASELINE_M, 0.1)


def known(values: Floats) -> list[float]:
    return values[np.isfinite(values)].tolist()


def test_a_point_is_triangulated_exactly() -> None:
    """(2, 0.5) m: eye 0 at +0.1 sees it at atan(0.4/2), eye 1 at atan(0.6/2)."""
    left, right = np.arctan(np.array([[0.2], [0.3]]))
    assert depth_m(left, right, 0.2) == pytest.approx(2.0)


def slip_of_depth_m(depth: float, bearing_rad: float, slip_rad: float) -> float:
    """What an error of eye 0's bearing makes of the depth."""
    y_m = depth * math.tan(bearing_rad)
    seen = [np.array([math.atan2(y_m - side, depth)]) for side in (0.01, -0.01)]
    return abs(float(depth_m(seen[0] + slip_rad, seen[1], 0.02)[0]) - depth)


def test_the_error_grows_with_the_square_of_the_depth() -> None:
    depths = np.geomspace(0.5, 8.0, 9)
    errors = [slip_of_depth_m(depth, 0.0, 1e-6) for depth in depths]
    slope = np.polyfit(np.log(depths), np.log(errors), 1)[0]
    assert slope == pytest.approx(2.0, abs=0.01)
    assert errors[4] == pytest.approx(depths[4] ** 2 * 1e-6 / 0.02, rel=1e-2)


def test_at_60_degrees_the_error_is_fourfold() -> None:
    ahead, aside = (slip_of_depth_m(2.0, math.radians(deg), 1e-6) for deg in (0.0, 60.0))
    assert aside / ahead == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize("depth", [0.6, 1.0, 2.0, 4.0])
def test_edges_of_a_strip_are_exact_to_within_a_ray(depth: float) -> None:
    """Without noise the lit share of a ray tells where in it the edge lies."""
    depths = depths_of([(depth, -0.43 * depth, 0.37 * depth)])
    assert known(depths.left_m) == pytest.approx([depth, depth], rel=1e-4)
    assert known(depths.right_m) == pytest.approx([depth, depth], rel=1e-4)


def test_several_things_at_several_depths_are_matched_in_order() -> None:
    """From the left: one at 2 m, one at 0.8 m, one at 3 m."""
    depths = depths_of([(2.0, 0.9, 2.0), (0.8, -0.2, 0.1), (3.0, -3.0, -1.8)])
    assert known(depths.left_m) == pytest.approx([2.0, 2.0, 0.8, 0.8, 3.0, 3.0], rel=1e-3)


def test_swapped_eyes_give_negative_depth_and_are_refused() -> None:
    left, right = np.arctan(np.array([[0.2], [0.3]]))
    assert depth_m(right, left, 0.2) == pytest.approx(-2.0)
    depths = depths_of([(1.0, -0.4, 0.4)], swapped=True)
    assert known(depths.left_m) == known(depths.right_m) == []


def test_a_bright_and_a_dark_edge_are_no_match() -> None:
    """Eye 0 sees only a rising edge, eye 1 only a falling one, at a fitting disparity."""
    rising = edges_in(view([(1.0, -9.0, 0.0)], 0.1), FOV_RAD, 0.1)
    falling = edges_in(view([(1.0, 0.0, 9.0)], -0.1), FOV_RAD, 0.1)
    both = match(rising, falling, BASELINE_M, 0.1)
    assert known(both.left_m) == []


def test_nothing_is_nearer_than_the_nearest() -> None:
    """A strip 0.3 m away is known to eyes that allow 0.2 m, not to those that end at 0.5 m."""
    left, right = (edges_in(view([(0.3, -0.1, 0.12)], y), FOV_RAD, 0.1) for y in (0.1, -0.1))
    assert known(match(left, right, BASELINE_M, 0.2).left_m) == pytest.approx([0.3, 0.3], rel=1e-3)
    assert known(match(left, right, BASELINE_M, 0.5).left_m) == []


def test_a_step_below_the_contrast_is_no_edge() -> None:
    faint = 0.3 * view([(1.0, -0.43, 0.37)], 0.1)
    assert np.count_nonzero(edges_in(faint, FOV_RAD, 0.2).signs) == 2
    assert np.count_nonzero(edges_in(faint, FOV_RAD, 0.4).signs) == 0


def test_one_ray_partly_lit_on_its_right_is_an_edge_within_it() -> None:
    """Ray 4 of 16 over 120° spans 30° to 22.5°; three quarters lit from its right end: 28.125°."""
    lit = np.array([[0.0] * 4 + [0.75] + [1.0] * 11], np.float32)
    edges = edges_in(lit, FOV_RAD, 0.1)
    assert np.flatnonzero(edges.signs[0]).tolist() == [3]
    assert edges.tangents[0, 3] == pytest.approx(math.tan(math.radians(28.125)), rel=1e-5)


def test_a_falling_edge_stands_right_of_the_ray_that_it_lies_in() -> None:
    """That ray is partly bright: a quarter of ray 4, from its left end at 30°: 28.125°."""
    lit = np.array([[1.0] * 4 + [0.25] + [0.0] * 11], np.float32)
    edges = edges_in(lit, FOV_RAD, 0.1)
    assert np.flatnonzero(edges.signs[0]).tolist() == [4]
    assert edges.tangents[0, 4] == pytest.approx(math.tan(math.radians(28.125)), rel=1e-5)
