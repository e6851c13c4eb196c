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
from reflexarc_sim_bridge.worlds.layers import Drift, Motion, Swing
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import AfterContact, Chassis, World
from support.drawn_worlds import scenes, stars, worlds
from support.scenes import STANDS_AT_M, scene_of, see_only_within
from support.slow_geometry import Floats, box, clearances_m, disc, polygon, ray_lengths_m
from support.slow_world import displaced_m, outlines_around

ERROR_M = 1e-5
TURNING = (Action("ahead", 10.0, 0.0), Action("turn", 10.0, 0.0, 1.0))
ONE_RAY = PolicyContract(retina=RetinaSpec(rays=1), actions=TURNING)
STAY = np.zeros(1, np.int64)

bearings = st.floats(-math.pi, math.pi).map(lambda v: round(v, 3))
radii = st.sampled_from([0.0, 0.0, 0.1, 0.3])
lengths = st.sampled_from([0.05, 1.0, 4.0])
motions = st.sampled_from([None, Drift(-3.0, 1.0), Swing(1.0, -2.0, 2.0)])


def gone(simulation: Simulation, ahead_m: float, left_m: float) -> float:
    """The share of a straight step that an agent has gone when it meets something, or infinity."""
    before_m = float(simulation.distance_m[0])
    if not simulation.drive(ahead_m / 0.1, left_m / 0.1, 0.0):
        return math.inf
    return (float(simulation.distance_m[0]) - before_m) / ahead_m


def way(length_m: float, bearing_rad: float) -> Floats:
    """A straight step that goes at least a little ahead, so that progress says how far."""
    step_m = length_m * np.array([math.cos(bearing_rad), math.sin(bearing_rad)])
    step_m[0] = step_m[0] if abs(step_m[0]) > 1e-2 * length_m else 1e-2 * length_m
    return step_m


def assert_first_touch(
    outlines: list[Outline], radius_m: float, path_m: Floats, share: float
) -> None:
    """An agent on a path (samples, 2) touches an obstacle there, and none before.

    Its middle is as far from the obstacle as its radius: no formula of a grown outline is used.
    """
    clear_m = np.min(clearances_m(outlines, path_m), axis=0, initial=9.0)
    shares = np.linspace(0.0, 1.0, len(path_m))
    assert (clear_m[shares < share - 1e-6] > radius_m - ERROR_M).all()
    if math.isfinite(share):
        there_m = path_m[:1] + share * (path_m[-1:] - path_m[:1])
        assert np.min(clearances_m(outlines, there_m)) == pytest.approx(radius_m, abs=2 * ERROR_M)


@given(scenes, radii, lengths, bearings, motions, st.sampled_from([0, 7, -7]))
@settings(max_examples=250, deadline=None)
def test_a_body_meets_what_the_slow_minkowski_sum_says(
    scene: list[Outline],
    radius_m: float,
    length_m: float,
    bearing_rad: float,
    motion: Motion | None,
    steps: int,
) -> None:
    check_a_step(scene, radius_m, way(length_m, bearing_rad), motion, steps)


@given(
    st.lists(stars, min_size=2, max_size=8), st.sampled_from([0.05, 0.2, 0.4]), bearings, motions
)
@settings(max_examples=150, deadline=None)
def test_a_round_body_meets_polygons_at_its_own_radius(
    scene: list[Outline], radius_m: float, bearing_rad: float, motion: Motion | None
) -> None:
    check_a_step(scene, radius_m, way(4.0, bearing_rad), motion, 3)


def check_a_step(
    scene: list[Outline], radius_m: float, step_m: Floats, motion: Motion | None, steps: int
) -> None:
    begins_m = np.array(displaced_m(motion, 0.1 * steps))
    ends_m = np.array(displaced_m(motion, 0.1 * (steps + 1)))
    # In the obstacles' own frame, where the agent's way is straight too.
    first_m, last_m = STANDS_AT_M - begins_m, STANDS_AT_M + step_m - ends_m
    path_m = first_m + np.linspace(0.0, 1.0, 1500)[:, np.newaxis] * (last_m - first_m)
    assume(np.min(clearances_m(scene, path_m[:1]), initial=9.0) > radius_m + ERROR_M)
    chassis = Chassis(radius_m=radius_m)
    simulation = scene_of(scene, ONE_RAY, motion=motion, steps=steps, chassis=chassis)
    assert_first_touch(scene, radius_m, path_m, gone(simulation, *step_m))


@given(scenes, bearings)
@settings(max_examples=150, deadline=None)
def test_a_path_along_a_ray_ends_where_the_ray_does(
    scene: list[Outline], bearing_rad: float
) -> None:
    """Eye and body never disagree: no slow geometry between them."""
    step_m = way(4.0, bearing_rad)
    heading_rad = math.atan2(step_m[1], step_m[0])
    start_m = np.array([STANDS_AT_M])
    assume(np.min(clearances_m(scene, start_m), initial=9.0) > 1e-3)
    simulation = scene_of(scene, ONE_RAY, heading_rad=heading_rad)
    simulation.params.agents.state["heading_rad"] = heading_rad
    looks = scene_of(scene, ONE_RAY, heading_rad=heading_rad)
    simulation.params.agents.state["heading_rad"] = 0.0
    length_m = gone(simulation, *step_m) * float(np.hypot(*step_m))
    if math.isinf(length_m):
        # A ray that grazes what the path passes by is nearly on its way out again.
        assert not see_only_within(looks, 4.0 - ERROR_M).any() or grazes(scene, heading_rad, 4.0)
    else:
        assert not see_only_within(looks, length_m - ERROR_M).any() or grazes(
            scene, heading_rad, 4.0
        )
        assert see_only_within(looks, length_m + ERROR_M).all() or grazes(scene, heading_rad, 4.0)


def grazes(scene: list[Outline], heading_rad: float, length_m: float) -> bool:
    """Whether something begins or ends within 20 µrad of a ray."""
    off = np.array([-2e-5, 0.0, 2e-5])
    met = ray_lengths_m(scene, np.array(STANDS_AT_M), heading_rad + off)
    met = np.minimum(met, length_m)
    return bool((np.ptp(met, axis=1) > 1e-3).any())


# By hand


@pytest.mark.parametrize("radius_m", [0.0, 0.25])
def test_a_step_into_a_box_ends_at_its_front(radius_m: float) -> None:
    x_m, y_m = STANDS_AT_M
    scene, chassis = [box(x_m + 2.0, y_m, 0.5, 0.5)], Chassis(radius_m=radius_m)
    simulation = scene_of(scene, ONE_RAY, chassis=chassis)
    assert gone(simulation, 3.0, 0.0) * 3.0 == pytest.approx(1.5 - radius_m, abs=1e-6)


def test_a_disc_meets_the_corner_of_a_box_at_its_own_radius() -> None:
    # The corner is 0.3 beside the path; a body of 0.5 touches it 0.4 before passing it.
    x_m, y_m = STANDS_AT_M
    simulation = scene_of(
        [box(x_m + 2.5, y_m + 1.3, 0.5, 1.0)], ONE_RAY, chassis=Chassis(radius_m=0.5)
    )
    assert gone(simulation, 3.0, 0.0) * 3.0 == pytest.approx(1.6, abs=1e-6)


def test_a_body_fits_into_a_notch_no_farther_than_its_round() -> None:
    # A notch of 90°, whose tip is 3 m ahead: a disc of radius r stops √2 r before the tip.
    x_m, y_m = STANDS_AT_M
    corners = [(5.0, -2.0), (5.0, 2.0), (1.0, 2.0), (3.0, 0.0), (1.0, -2.0)]
    scene = [polygon(np.array(corners) + np.array([x_m, y_m]))]
    simulation = scene_of(scene, ONE_RAY, chassis=Chassis(radius_m=0.3))
    assert gone(simulation, 4.0, 0.0) * 4.0 == pytest.approx(3.0 - 0.3 * math.sqrt(2), abs=1e-5)


@pytest.mark.parametrize(("gap_m", "meets"), [(0.19, True), (0.21, False)])
def test_an_agent_at_rest_is_hit_by_what_drifts_onto_it(gap_m: float, meets: bool) -> None:
    x_m, y_m = STANDS_AT_M
    drifting = [disc(x_m + 0.5 + gap_m, y_m, 0.5)]
    simulation = scene_of(drifting, ONE_RAY, motion=Drift(-2.0, 0.0))
    assert simulation.drive(0.0, 0.0, 0.0) == meets


def test_who_keeps_up_with_a_drifting_obstacle_never_meets_it() -> None:
    x_m, y_m = STANDS_AT_M
    simulation = scene_of([box(x_m + 0.6, y_m, 0.5, 0.5)], ONE_RAY, motion=Drift(3.0, 1.0))
    assert not simulation.drive(3.0, 1.0, 0.0)
    assert scene_of([box(x_m + 0.6, y_m, 0.5, 0.5)], ONE_RAY).drive(3.0, 1.0, 0.0)


@given(scenes, radii)
@settings(max_examples=60, deadline=None)
def test_who_stands_still_outside_meets_nothing(scene: list[Outline], radius_m: float) -> None:
    start_m = np.array([STANDS_AT_M])
    assume(np.min(clearances_m(scene, start_m), initial=9.0) > radius_m + ERROR_M)
    simulation = scene_of(scene, ONE_RAY, chassis=Chassis(radius_m=radius_m))
    assert not simulation.drive(0.0, 0.0, 0.0)


# In whole worlds


@given(worlds, st.integers(0, 2**64 - 1))
@settings(max_examples=25, deadline=None)
def test_nobody_ever_stands_inside_an_obstacle(world: World, seed: int) -> None:
    actions = (Action("ahead", 3.0, 0.0), Action("left", 2.0, 2.0), Action("right", 1.0, -3.0))
    contract = PolicyContract(retina=RetinaSpec(rays=1, range_m=0.5), actions=actions)
    simulation = Simulation(world, contract, np.array([seed], np.uint64))
    generator, radius_m = np.random.default_rng(seed), world.chassis.radius_m
    for _ in range(4):
        before = [o for o in outlines_around(simulation, 0, 1.0) if math.isfinite(o.x_m)]
        place_m = np.array([[simulation.x_m[0], simulation.y_m[0]]])
        assert np.min(clearances_m(before, place_m), initial=9.0) > radius_m - ERROR_M
        for _ in range(12):
            simulation.step(generator.integers(0, 3, 1))


# What follows a contact


def test_a_contact_moves_an_agent_aside_and_not_ahead() -> None:
    simulation = Simulation(World("plain"), PolicyContract(), test_seeds(256))
    met = np.zeros(256, np.bool_)
    while not met.any():
        x_m, y_m = simulation.x_m.copy(), simulation.y_m.copy()
        met = simulation.step(np.zeros(256, np.int64))
    assert (simulation.x_m[met] - x_m[met] <= 0.1).all()
    assert (np.abs(simulation.y_m[met] - y_m[met]) > 0.0).all()
    np.testing.assert_array_equal(simulation.y_m[~met], y_m[~met])
    np.testing.assert_array_equal(simulation.contacts, met)


def test_places_are_uniform_among_the_free() -> None:
    """Of all free places of one line, each twentieth is drawn as often as it is long."""
    simulation = Simulation(World("plain"), PolicyContract(), np.full(20_000, 11, np.uint64))
    around = [o for o in outlines_around(simulation, 0, 20.0) if abs(o.x_m) < 1.0]
    grid_m = np.stack([np.zeros(20_000), (np.arange(20_000) + 0.5) / 1000.0], axis=1)
    free = np.min(clearances_m(around, grid_m), axis=0) > 0.0
    expected = free.reshape(20, 1000).sum(axis=1) / free.sum()
    found = np.histogram(simulation.y_m, bins=20, range=(0.0, 20.0))[0] / 20_000
    assert np.abs(found - expected).max() < 4.5 * math.sqrt(0.05 * 0.95 / 20_000)


def test_a_ghost_passes_through_seeing_nothing_else_and_counts_once() -> None:
    x_m, y_m = STANDS_AT_M
    ghost = Chassis(after_contact=AfterContact.GHOST)
    scene = [box(x_m + 0.65, y_m, 0.4, 0.4)]  # from 0.25 to 1.05 ahead
    simulation = scene_of(scene, ONE_RAY, chassis=ghost)
    met, seen = [], []
    for _ in range(11):
        met.append(simulation.drive(1.0, 0.0, 0.0))
        seen.append(int(simulation.sense()[0, 0, 0, 0]))
    assert met == [k == 2 for k in range(11)]
    assert simulation.contacts[0] == 1
    assert float(simulation.distance_m[0]) == pytest.approx(1.1)
    assert (simulation.y_m[0], seen[2:10], seen[10]) == (pytest.approx(y_m), [255] * 8, 0)
