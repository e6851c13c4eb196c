"""Room around a body and ahead of it, against slow geometry that shares no formula with it."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.surroundings import AgentSurroundings
from reflexarc_sim_bridge.worlds.layers import Drift, Motion, Swing
from reflexarc_sim_bridge.worlds.world import Chassis
from support.drawn_worlds import headings, scenes
from support.scenes import STANDS_AT_M, scene_of
from support.slow_geometry import box, clearances_m, disc, polygon
from support.slow_world import displaced_m

RANGE_M, SPEED_MPS = 4.0, 2.0
ACTIONS = (Action("ahead", SPEED_MPS, 0.0), Action("turn", SPEED_MPS, 0.0, 1.0))
CONTRACT = PolicyContract(retina=RetinaSpec(rays=1, range_m=RANGE_M), actions=ACTIONS)
HERE_M = np.array([STANDS_AT_M])
ERROR_M = 1e-5

radii = st.sampled_from([0.0, 0.1, 0.3])
motions = st.sampled_from([None, None, Drift(-3.0, 1.0), Drift(1.9, 0.1), Swing(1.0, -2.0, 4.0)])


def room_of(simulation: Simulation) -> tuple[float, float]:
    clearance_m, ahead_s = np.empty(1, np.float32), np.empty(1, np.float32)
    AgentSurroundings(simulation).measure(clearance_m, ahead_s)
    return float(clearance_m[0]), float(ahead_s[0])


@given(scenes, radii, motions, st.sampled_from([0, 7, -7]))
@settings(max_examples=150, deadline=None)
def test_clearance_is_the_distance_to_the_nearest_outline(
    scene: list[Outline], radius_m: float, motion: Motion | None, steps: int
) -> None:
    there_m = HERE_M - np.array(displaced_m(motion, 0.1 * steps))  # in the obstacles' own frame
    away_m = float(np.min(clearances_m(scene, there_m), initial=RANGE_M))
    simulation = scene_of(
        scene, CONTRACT, motion=motion, steps=steps, chassis=Chassis(radius_m=radius_m)
    )
    expected_m = max(max(away_m, 0.0) - radius_m, 0.0)
    assert room_of(simulation)[0] == pytest.approx(expected_m, abs=ERROR_M)


@given(scenes, radii, motions, headings, st.sampled_from([0, 7]))
@settings(max_examples=150, deadline=None)
def test_time_ahead_ends_at_the_first_touch_and_not_before(
    scene: list[Outline],
    radius_m: float,
    motion: Motion | None,
    heading_rad: float,
    steps: int,
) -> None:
    now_s = 0.1 * steps
    error_m = 0.02 if isinstance(motion, Swing) else ERROR_M  # of its chords
    place_m = places_m(motion, heading_rad, now_s, np.zeros(1))
    assume(np.min(clearances_m(scene, place_m), initial=9.0) > radius_m + error_m)
    simulation = scene_of(
        scene,
        CONTRACT,
        motion=motion,
        steps=steps,
        chassis=Chassis(radius_m=radius_m),
        heading_rad=heading_rad,
    )
    ahead_s = room_of(simulation)[1]
    farthest_m = RANGE_M - radius_m
    times_s = np.linspace(0.0, farthest_m / SPEED_MPS, 1500)
    path_m = places_m(motion, heading_rad, now_s, times_s)
    beyond = np.hypot(*(path_m - place_m).T) > farthest_m
    last_s = times_s[beyond.argmax()] if beyond.any() else times_s[-1]
    clear_m = np.min(clearances_m(scene, path_m), axis=0, initial=9.0)
    before = times_s < min(ahead_s, last_s) - 1e-3
    assert (clear_m[before] > radius_m - error_m).all()
    if math.isfinite(ahead_s):
        met_m = places_m(motion, heading_rad, now_s, np.array([ahead_s]))
        assert np.min(clearances_m(scene, met_m)) == pytest.approx(radius_m, abs=2 * error_m)


def places_m(
    motion: Motion | None, heading_rad: float, now_s: float, times_s: np.ndarray
) -> np.ndarray:
    """Where a body is that goes straight on, in the obstacles' own frame: (n, 2)."""
    direction = np.array([math.cos(heading_rad), math.sin(heading_rad)])
    gone_m = SPEED_MPS * times_s[:, np.newaxis] * direction
    moved_m = [displaced_m(motion, now_s + float(time_s)) for time_s in times_s]
    return HERE_M + gone_m - np.array(moved_m)


# By hand


def test_a_box_two_metres_ahead_is_met_after_its_distance_over_speed() -> None:
    x_m, y_m = STANDS_AT_M
    scene = [box(x_m + 2.5, y_m, 0.5, 0.5)]
    assert room_of(scene_of(scene, CONTRACT)) == pytest.approx((2.0, 1.0))
    wide = scene_of(scene, CONTRACT, chassis=Chassis(radius_m=0.5))
    assert room_of(wide) == pytest.approx((1.5, 0.75))


def test_what_lies_behind_counts_as_room_and_is_not_met() -> None:
    x_m, y_m = STANDS_AT_M
    clearance_m, ahead_s = room_of(scene_of([disc(x_m - 1.0, y_m, 0.25)], CONTRACT))
    assert clearance_m == pytest.approx(0.75)
    assert ahead_s == math.inf


@pytest.mark.parametrize("heading_rad", [0.0, 1.0])
def test_inside_of_a_polygon_there_is_no_room_and_no_time(heading_rad: float) -> None:
    x_m, y_m = STANDS_AT_M
    corners = np.array([(3.0, -3.0), (3.0, 3.0), (-3.0, 3.0), (-3.0, -3.0)])
    corners += np.array([x_m, y_m])
    assert room_of(scene_of([polygon(corners)], CONTRACT, heading_rad=heading_rad)) == (0.0, 0.0)


def test_with_nothing_in_range_the_room_is_the_range_less_the_body() -> None:
    x_m, y_m = STANDS_AT_M
    scene = [disc(x_m + 4.6, y_m, 0.5)]
    assert room_of(scene_of(scene, CONTRACT)) == (4.0, math.inf)
    near = scene_of([disc(x_m + 4.4, y_m, 0.5)], CONTRACT)
    assert room_of(near) == pytest.approx((3.9, 1.95))


def test_an_oncoming_wall_is_met_after_the_distance_over_the_sum_of_speeds() -> None:
    x_m, y_m = STANDS_AT_M
    simulation = scene_of([box(x_m + 3.5, y_m, 0.5, 0.5)], CONTRACT, motion=Drift(-4.0, 0.0))
    assert room_of(simulation)[1] == pytest.approx(0.5)


def test_who_keeps_up_is_never_met() -> None:
    x_m, y_m = STANDS_AT_M
    drift = Drift(SPEED_MPS, 0.0)
    assert room_of(scene_of([box(x_m + 1.5, y_m, 0.5, 0.5)], CONTRACT, motion=drift))[1] == math.inf
