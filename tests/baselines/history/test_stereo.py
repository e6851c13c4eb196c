import numpy as np
import pytest

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.history.stereo import Stereo, eye_pair
from reflexarc_baselines.rays import bearings_rad
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.simulation.scene import Outline
from support.scenes import STANDS_AT_M, scene_of
from support.strip_views import view


def box(x_m: float, y_m: float, half_width_m: float) -> Outline:
    """A white box half a metre deep, whose near face is at this place before the body."""
    near_m, left_m = STANDS_AT_M[0] + x_m, STANDS_AT_M[1] + y_m + half_width_m
    right_m, far_m = left_m - 2 * half_width_m, near_m + 0.5
    corners_m = np.array([(far_m, left_m), (near_m, left_m), (near_m, right_m), (far_m, right_m)])
    middle_x_m, middle_y_m = corners_m.mean(axis=0)
    white = (1.0, 1.0, 1.0)
    return Outline(middle_x_m, middle_y_m, 0.0, corners_m, is_box=True, colour=white, layer=0)


@pytest.mark.parametrize("ahead_m", [0.5, 0.8, 1.1])
def test_the_simulated_eyes_see_how_far_the_face_of_a_box_is(ahead_m: float) -> None:
    """Eye 0 of the simulator is the left one; 16 samples a ray, so edges are to 0.5° and a depth
    Z to Z² · 0.5° / 0.2 m, 5 cm at 1.1 m."""
    policy = Stereo()
    scene = scene_of([box(ahead_m, 0.0, 0.3 * ahead_m)], policy.contract)
    scene.sense()
    rays_m = policy.distances_m(scene.stacks)[0]
    assert rays_m[[7, 8]] == pytest.approx(ahead_m, rel=0.06)
    assert rays_m[[0, 1, 14, 15]].tolist() == [eye_pair().range_m] * 4


def seen(strips: list[tuple[float, float, float]]) -> tuple[Floats, Floats]:
    """How far each ray's thing is said to be, and which rays either eye sees lit."""
    lit = np.stack([view(strips, 0.1), view(strips, -0.1)], axis=1)
    retina = np.round(255 * lit)[:, np.newaxis, ..., np.newaxis].astype(np.uint8)
    policy = Stereo(unknown_m=0.3, nearest_m=0.2, contrast=0.05)
    return policy.distances_m(retina)[0], lit[0].max(axis=0) > 0.01


@pytest.mark.parametrize(("right_m", "left_m"), [(-0.7, 0.4), (-0.7, 9.0), (-9.0, 0.4)])
def test_each_lit_ray_is_as_long_as_the_face_is_away_along_it(
    right_m: float, left_m: float
) -> None:
    """A face 1 m ahead, one of whose ends may be out of sight: 1 m / cos φ along every ray that is
    lit, whole or in part and in either eye; nothing within range along the others."""
    rays_m, is_lit = seen([(1.0, right_m, left_m)])
    range_m = eye_pair().range_m
    face_m = np.minimum(1.0 / np.cos(bearings_rad(eye_pair())), range_m)
    assert 8 <= is_lit.sum() <= 14
    assert rays_m == pytest.approx(np.where(is_lit, face_m, range_m), rel=0.02)


def test_between_two_depths_it_takes_the_nearer() -> None:
    """A near face covers the left end of a far one: one run of light, 0.6 m on its left edge and
    1.2 m on its right one. Nobody sees where one ends: all of it counts as the nearer."""
    rays_m, is_lit = seen([(0.6, 0.0, 0.4), (1.2, -0.8, 0.3)])
    near_m = 0.6 / np.cos(bearings_rad(eye_pair()))
    assert rays_m[is_lit] == pytest.approx(near_m[is_lit], rel=0.03)


def test_the_contract_has_two_eyes_that_see_colours_only() -> None:
    """One eye alone tells no distance: `nearness` would be a range finder in disguise."""
    assert (eye_pair().eyes, eye_pair().shading.value) == (2, "colour")


def test_a_field_that_is_lit_all_over_is_unknown() -> None:
    full: RetinaBatch = np.full((1, 1, 2, 16, 1), 255, np.uint8)
    policy = Stereo(unknown_m=0.7)
    assert policy.distances_m(full)[0].tolist() == pytest.approx([0.7] * 16)
    assert policy.decide(full)[1].tolist() == [0]


def test_nothing_in_sight_is_free_as_far_as_it_sees() -> None:
    dark: RetinaBatch = np.zeros((1, 1, 2, 16, 1), np.uint8)
    assert Stereo().distances_m(dark)[0].tolist() == [eye_pair().range_m] * 16


def test_it_beats_random_motion() -> None:
    policy = Stereo()
    assert measure(policy, policy.contract, agents=128, steps=200).contacts_per_100m < 0.4 * 48.0
