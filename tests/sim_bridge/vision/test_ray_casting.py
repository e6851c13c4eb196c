import dataclasses
import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.sensing import ray_values
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import Scanner, World
from support.drawn_worlds import SIDEWAYS, TURNING, contracts, headings, scenes, worlds
from support.scenes import STANDS_AT_M, scene_of, see_only_within
from support.slow_geometry import box, clearances_m, disc, mirrored, polygon
from support.slow_world import (
    directions_rad,
    eye_place_m,
    first_met_m,
    outlines_around,
    slow_retina,
)

ERROR_M = 2e-5
"""Lengths are float32: good to so much within some metres, where a ray does not graze."""


def eye_contract(**fields: object) -> PolicyContract:
    return PolicyContract(retina=RetinaSpec(**fields), actions=TURNING)  # type: ignore[arg-type]  # by name


def one_ray_sees(outlines: list[Outline], length_m: float, heading_rad: float = 0.0) -> None:
    """The ray straight ahead meets something at that length, within its error."""
    simulation = scene_of(outlines, eye_contract(rays=1), heading_rad=heading_rad)
    assert see_only_within(simulation, length_m + ERROR_M).all()
    assert not see_only_within(simulation, length_m - ERROR_M).any()


# Analytic intersections


def test_a_ray_meets_the_front_of_a_box() -> None:
    x_m, y_m = STANDS_AT_M
    one_ray_sees([box(x_m + 3.0, y_m + 0.4, 0.5, 0.5)], 2.5)


def test_a_slanted_ray_meets_the_side_of_a_box() -> None:
    x_m, y_m = STANDS_AT_M
    one_ray_sees([box(x_m + 1.0, y_m + 2.0, 5.0, 0.5)], 1.5 / math.sin(0.7), 0.7)


def test_a_ray_meets_a_disc_where_its_half_chord_begins() -> None:
    x_m, y_m = STANDS_AT_M
    one_ray_sees([disc(x_m + 3.0, y_m + 0.6, 1.0)], 3.0 - 0.8)


def test_a_ray_meets_the_slope_of_a_triangle() -> None:
    # The slope from (2, −1) to (4, 1) crosses the ray at 3.
    corners = np.array([(2.0, -1.0), (5.0, 0.0), (4.0, 1.0)]) + STANDS_AT_M
    one_ray_sees([polygon(corners)], 3.0)


def test_a_ray_enters_the_hollow_of_a_concave_polygon() -> None:
    # An arrowhead, open towards the eye: its notch lies 1 m behind its two tips.
    corners = np.array([(2.0, -1.0), (4.0, 0.0), (2.0, 1.0), (3.0, 0.0)]) + STANDS_AT_M
    one_ray_sees([polygon(corners)], 3.0)


def test_no_ray_slips_through_where_two_sides_meet() -> None:
    for turned in np.linspace(0.0, 0.5, 200):
        corners = [(math.cos(turned + k), math.sin(turned + k)) for k in range(6)]
        hexagon = polygon(np.array(corners) + STANDS_AT_M + (2.5, 0.0))
        bearing = math.atan2(corners[3][1], 2.5 + corners[3][0])
        one_ray_met = scene_of([hexagon], eye_contract(rays=1), heading_rad=bearing)
        assert see_only_within(one_ray_met, 5.0).all()


# The slow exact geometry


@given(contracts, scenes, headings)
@settings(max_examples=120, deadline=None)
def test_rays_agree_with_the_slow_exact_geometry(
    contract: PolicyContract, scene: list[Outline], heading_rad: float
) -> None:
    heading_rad = heading_rad if contract.actions == TURNING else 0.0
    simulation = scene_of(scene, contract, heading_rad=heading_rad)
    eyes = range(contract.retina.eyes)
    places = np.array([eye_place_m(simulation, 0, eye) for eye in eyes])
    clear_m = clearances_m([o for o in scene if not o.is_box and not o.is_disc], places)
    assume(np.min(clear_m, initial=1.0) > 0.0)  # a body's eye is in no polygon
    assume(np.abs(clearances_m(scene, places)).min(initial=1.0) > 1e-3)
    for eye, values in enumerate(simulation.sense()[0].astype(float)):
        least, most = slow_retina(simulation, 0, eye, scene)
        assert (values >= least - 1.0).all()
        assert (values <= most + 1.0).all()
    if contract.retina.samples == 1:
        assert_lengths(simulation, scene)


def assert_lengths(simulation: Simulation, outlines: list[Outline]) -> None:
    """Every ray's length to 20 µm: seen within a range that is longer, not within a shorter one."""
    spec, bearings = simulation.contract.retina, directions_rad(simulation, 0)
    bounds = [
        first_met_m(outlines, eye_place_m(simulation, 0, eye), bearings) for eye in range(spec.eyes)
    ]
    least_m, most_m = np.array(bounds).transpose(1, 0, 2)
    for length_m in least_m[(least_m > ERROR_M) & (least_m < spec.range_m)][:12]:
        for within_m in (length_m - ERROR_M, length_m + ERROR_M):
            seen = see_only_within(simulation, within_m)
            assert seen[most_m < within_m - ERROR_M].all()
            assert not seen[least_m > within_m + ERROR_M].any()


@given(worlds, contracts, st.integers(0, 2**64 - 1))
@example(World("plain"), eye_contract(rays=64, fov_rad=math.tau), 5)
@example(World("plain"), PolicyContract(), 5)
@settings(max_examples=40, deadline=None)
def test_everything_in_reach_is_seen_in_any_world_wherever_the_agent_has_gone(
    world: World, contract: PolicyContract, seed: int
) -> None:
    simulation = Simulation(world, contract, np.array([seed], np.uint64))
    for part in range(2):
        for step in range(7 + 6 * part):
            simulation.step(np.array([(seed + step * step // 3) % 3]))
        retinas = simulation.sense()[0].astype(float)
        around = outlines_around(simulation, 0, contract.retina.range_m + 0.4)
        for eye, values in enumerate(retinas):
            place_m = eye_place_m(simulation, 0, eye)[np.newaxis]
            if np.min(clearances_m(around, place_m), initial=1.0) < 1e-3:
                continue  # the eye of a wide head within an obstacle
            least, most = slow_retina(simulation, 0, eye, around)
            assert (values >= least - 1.0).all()
            assert (values <= most + 1.0).all()


@pytest.mark.parametrize("cells", [400_000_000, -400_000_000, 2**50])
def test_distance_costs_no_precision(cells: int) -> None:
    """A billion metres away an agent sees the same scene to the same bit."""
    scene = [box(3.0, 1.5, 0.3, 0.4), disc(2.5, 0.2, 0.4), disc(4.0, -2.0, 0.9)]
    here = scene_of(scene, eye_contract(rays=64, fov_rad=math.tau), heading_rad=0.3)
    there = scene_of(scene, eye_contract(rays=64, fov_rad=math.tau), heading_rad=0.3)
    there.params.agents.state["cell_x"] += cells
    there.params.agents.state["cell_y"] -= cells
    there.params.agents.layer_cells[:] += (cells, -cells)
    assert here.sense().tobytes() == there.sense().tobytes()
    assert len(np.unique(here.stacks)) > 10


@given(contracts, scenes, headings)
@settings(max_examples=80, deadline=None)
def test_a_mirrored_scene_gives_the_mirrored_retina(
    contract: PolicyContract, scene: list[Outline], heading_rad: float
) -> None:
    heading_rad = heading_rad if contract.actions == TURNING else 0.0
    simulation = scene_of(scene, contract, heading_rad=heading_rad)
    mirror_scene = [mirrored(outline, STANDS_AT_M[1]) for outline in scene]
    mirror = scene_of(mirror_scene, contract, heading_rad=-heading_rad)
    seen = simulation.sense()[0].astype(int)
    reflected = mirror.sense()[0, ::-1, ::-1].astype(int)
    # Bearings are rounded, so a ray may graze on one side what it passes on the other.
    differs = (np.abs(seen - reflected) > 1).any(axis=-1)
    for eye in range(contract.retina.eyes):
        least, most = slow_retina(simulation, 0, eye, scene)
        assert not differs[eye][(most - least < 1.0).all(axis=-1)].any()


def test_index_0_is_the_leftmost_ray() -> None:
    x_m, y_m = STANDS_AT_M
    values = scene_of([box(x_m + 0.3, y_m + 2.0, 0.3, 0.3)], eye_contract()).sense()[0, 0, :, 0]
    assert values.argmax() <= 1
    assert (values[8:] == 0).all()


# Shades


@given(
    st.integers(0, 255), st.floats(0.2, 6.0), st.sampled_from([0.4, 5.0]), st.sampled_from(Shading)
)
@settings(max_examples=60, deadline=None)
def test_a_value_is_the_runtime_s_own_formula(
    tint: int, front_m: float, range_m: float, shading: Shading
) -> None:
    x_m, y_m = STANDS_AT_M
    front_x, tone = float(np.float32(x_m + front_m + 1.0)), tint / 255
    contract = eye_contract(rays=1, range_m=range_m, shading=shading)
    values = scene_of([box(front_x, y_m, 1.0, 1.0, (tone,) * 3)], contract).sense()
    nearness = shading is Shading.NEARNESS
    wanted = ray_values.shade(tone, front_x - 1.0 - x_m, range_m, nearness)
    assert abs(int(values[0, 0, 0, 0]) - wanted) <= 1


def test_a_ray_of_several_samples_shows_the_mean_of_its_sub_rays() -> None:
    scene = [box(3.0, 1.5, 0.3, 0.4), disc(2.5, 0.2, 0.4, (0.2, 0.4, 0.9)), disc(2.0, -2.0, 0.9)]
    for samples, channels in itertools.product((2, 3, 16), (1, 3)):
        fine = eye_contract(rays=16 * samples, channels=channels)
        smooth = eye_contract(
            rays=16, samples=samples, channels=channels, beams=BeamRule.NEAREST_BEAM
        )
        parts = scene_of(scene, fine).sense()[0, 0].astype(float)
        mean = parts.reshape(16, samples, channels).mean(axis=1)
        seen = scene_of(scene, smooth).sense()[0, 0]
        # Either value is rounded to half a step.
        assert np.abs(seen - mean).max() <= 1.0
        assert len(np.unique(seen)) > 6


def test_grey_is_the_weighted_sum_of_the_colours() -> None:
    x_m, y_m = STANDS_AT_M
    scene = [box(x_m + 2.0, y_m, 0.5, 5.0, (0.2, 0.6, 1.0))]
    spec = RetinaSpec(rays=3, shading=Shading.COLOUR)
    grey = scene_of(scene, PolicyContract(retina=spec)).sense()[0, 0, 1]
    colours = dataclasses.replace(spec, channels=3)
    red_green_blue = scene_of(scene, PolicyContract(retina=colours)).sense()[0, 0, 1]
    assert red_green_blue.tolist() == [51, 153, 255]
    assert grey.tolist() == [round(0.299 * 51 + 0.587 * 153 + 0.114 * 255)]


def test_two_eyes_stand_half_a_baseline_to_each_side() -> None:
    x_m, y_m = STANDS_AT_M
    spec = RetinaSpec(rays=1, eyes=2, baseline_m=0.5)
    # Beside the path of the middle; only the left eye, at +0.25, looks onto it.
    simulation = scene_of([box(x_m + 2.0, y_m + 0.3, 0.5, 0.2)], PolicyContract(retina=spec))
    left, right = simulation.sense()[0, :, 0, 0]
    assert (left, right) == (ray_values.shade(1.0, 1.5, 5.0, True), 0)


# Behind a scanner


EYES = [
    RetinaSpec(rays=16),
    RetinaSpec(rays=7, fov_rad=2.0),
    RetinaSpec(rays=64, range_m=3.0, samples=3),
    RetinaSpec(rays=180),  # a beam on each line between two sectors
    RetinaSpec(rays=90, fov_rad=3.0, shading=Shading.COLOUR),
]


@pytest.mark.parametrize("rule", BeamRule)
@pytest.mark.parametrize("eye", EYES)
def test_behind_a_scanner_the_eye_sees_what_the_runtime_makes_of_the_sweep(
    eye: RetinaSpec, rule: BeamRule
) -> None:
    """The sweep is cast whole: 181 rays over 181° stand at the 181 beams over 180°."""
    eye, scanner = dataclasses.replace(eye, beams=rule), Scanner()
    every_beam = RetinaSpec(rays=181, fov_rad=math.pi * 181 / 180, range_m=eye.range_m)
    differs = 0
    for seed in test_seeds(24):
        seeds = np.array([seed])
        plain = Simulation(World("plain"), reference_contract(every_beam), seeds)
        lengths_m = plain.distances()[::-1].astype(np.float64)
        ranges_m = np.where(lengths_m < eye.range_m, lengths_m, math.inf)
        expected = retina_from_scan(Scan(scanner.start_rad, -scanner.start_rad, ranges_m), eye)
        scanned = Simulation(World("scanned", scanner=scanner), reference_contract(eye), seeds)
        assert np.abs(scanned.sense()[0].astype(int) - expected.astype(int)).max() <= 1
        differs += int((scanned.stacks[0, 0] != expected).sum())
    assert differs <= 2  # bearings are rounded; a beam may graze


def test_only_the_beams_of_a_sector_count_and_all_of_them_do() -> None:
    """A post in each ray's sector, 1° off its edge, is seen by that ray alone."""
    x_m, y_m = STANDS_AT_M
    eye = RetinaSpec(rays=4, fov_rad=math.pi, beams=BeamRule.SECTOR_MINIMUM)
    for bearing_deg, ray in ((46.0, 0), (44.0, 1), (1.0, 1), (-1.0, 2), (-44.0, 2), (-89.0, 3)):
        bearing_rad = math.radians(bearing_deg)
        post = disc(x_m + 2.0 * math.cos(bearing_rad), y_m + 2.0 * math.sin(bearing_rad), 0.01)
        scene = scene_of([post], PolicyContract(retina=eye), scanner=Scanner())
        assert np.flatnonzero(scene.sense()[0, 0, :, 0]).tolist() == [ray]
        nearest = int(scene.distances().argmin())
        assert abs(float(scene.distances()[nearest]) - 1.99) < 1e-4
        assert abs(float(scene.bearings_rad[nearest]) - bearing_rad) < 1e-9


# The nearest of several samples


def test_a_ray_shows_its_nearest_sample_and_with_one_sample_the_rules_are_one() -> None:
    scene = [box(3.0, 1.5, 0.3, 0.4), disc(2.5, 0.2, 0.4), disc(2.0, -2.0, 0.9)]
    for samples in (1, 2, 3, 16):
        nearest = eye_contract(samples=samples, beams=BeamRule.SECTOR_MINIMUM)
        fine = eye_contract(rays=16 * samples, beams=BeamRule.NEAREST_BEAM)
        parts = scene_of(scene, fine).sense()[0, 0, :, 0].reshape(16, samples)
        np.testing.assert_array_equal(
            scene_of(scene, nearest).sense()[0, 0, :, 0], parts.max(axis=1)
        )


@pytest.mark.parametrize("shading", Shading)
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("side", [1, -1])
def test_the_nearest_thing_hides_a_brighter_one_beside_it(
    shading: Shading, channels: int, side: int
) -> None:
    x_m, y_m = STANDS_AT_M
    dark, bright = (0.2, 0.2, 0.2), (1.0, 1.0, 1.0)
    near, far = (
        box(x_m + 1.5, y_m + side * 10.0, 0.5, 10.0, dark),
        box(x_m + 2.0, y_m - side * 10.0, 0.5, 10.0, bright),
    )
    eye = RetinaSpec(
        rays=1,
        samples=2,
        fov_rad=0.1,
        channels=channels,
        shading=shading,
        beams=BeamRule.SECTOR_MINIMUM,
    )
    seen = scene_of([near, far], PolicyContract(retina=eye)).sense()[0, 0, 0]
    length_m = 1.0 / math.cos(0.025)
    wanted = ray_values.shade(0.2, length_m, 5.0, shading is Shading.NEARNESS)
    assert seen.tolist() == [wanted] * channels


def test_a_sideways_agent_and_a_turning_one_with_heading_0_see_the_same() -> None:
    spec = RetinaSpec(rays=31, fov_rad=5.0)
    sideways, turning = (
        Simulation(World("two"), PolicyContract(retina=spec, actions=actions), test_seeds(64))
        for actions in (SIDEWAYS, TURNING)
    )
    np.testing.assert_array_equal(sideways.sense(), turning.sense())


@pytest.mark.parametrize("turned_rad", [0.0, 0.7, 2.0])
def test_an_eye_within_an_obstacle_sees_nothing_else(turned_rad: float) -> None:
    """The eyes of a wide head are where its body is not."""
    x_m, y_m = STANDS_AT_M
    spec = RetinaSpec(rays=40, eyes=2, baseline_m=1.0, samples=2)
    scene = [box(x_m, y_m + 0.5, 0.2, 0.3, (0.4,) * 3, turned_rad), box(x_m + 2.0, y_m, 0.1, 4.0)]
    left, right = scene_of(scene, PolicyContract(retina=spec)).sense()[0, :, :, 0]
    assert (left == round(0.4 * 255)).all()
    assert right.max() > round(0.4 * 255)
