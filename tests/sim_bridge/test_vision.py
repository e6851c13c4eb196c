import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime import retina
from reflexarc_runtime.contract import PolicyContract, RetinaSpec, Shading
from reflexarc_sim_bridge.params import NEAR_ROWS, eye_params
from reflexarc_sim_bridge.seeds import test_seeds
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.vision import look, shade_all
from reflexarc_sim_bridge.world_files import world_named
from support.slow_geometry import Obstacle, distance_m
from support.slow_world import obstacles_around

coordinates = st.floats(-6.0, 6.0).map(lambda v: round(v, 4))
halves = st.floats(0.05, 1.5).map(lambda v: round(v, 4))
rectangles = st.builds(Obstacle, coordinates, coordinates, halves, halves, st.just(False))
discs = st.builds(lambda x, y, r: Obstacle(x, y, r, r, True), coordinates, coordinates, halves)
scenes = st.lists(rectangles | discs, max_size=6)
fields_of_view = st.sampled_from([math.pi, math.radians(60), math.radians(270), 2 * math.pi])
specs = st.builds(
    RetinaSpec,
    rays=st.integers(1, 40),
    fov_rad=fields_of_view,
    range_m=st.sampled_from([0.4, 1.5, 5.0]),
)


def seen(
    spec: RetinaSpec, scene: list[Obstacle]
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    near = np.zeros((NEAR_ROWS, len(scene) + 1))
    for k, o in enumerate(scene):
        near[:, k] = (o.x_m, o.y_m, o.half_length_m, o.half_width_m, o.disc, 0.2 + 0.1 * k)
    distance, colour = np.zeros((2, spec.rays), np.float32)
    look(eye_params(spec), near, len(scene), 0.0, 0.0, distance, colour)
    return distance, colour


def bearings(spec: RetinaSpec) -> list[float]:
    return [retina.ray_bearing_rad(ray, spec.rays, spec.fov_rad) for ray in range(spec.rays)]


def ambiguous(obstacle: Obstacle, bearing: float) -> bool:
    """Whether a ray grazes the obstacle: the outline moved by 10 µm decides what it meets."""
    smaller, larger = (
        dataclasses.replace(
            obstacle,
            half_length_m=obstacle.half_length_m + by,
            half_width_m=obstacle.half_width_m + by,
        )
        for by in (-1e-5, 1e-5)
    )
    near, far = (distance_m(o, 0.0, 0.0, bearing) for o in (larger, smaller))
    return not far - near < 1e-3 and near < 6.0


@given(specs, scenes)
@settings(max_examples=400, deadline=None)
def test_rays_agree_with_the_slow_exact_geometry(spec: RetinaSpec, scene: list[Obstacle]) -> None:
    distance, colour = seen(spec, scene)
    for ray, bearing in enumerate(bearings(spec)):
        if any(ambiguous(obstacle, bearing) for obstacle in scene):
            continue
        exact = [distance_m(obstacle, 0.0, 0.0, bearing) for obstacle in scene]
        nearest = min([*exact, spec.range_m])
        assert distance[ray] == pytest.approx(nearest, abs=2e-5)
        if nearest > spec.range_m - 1e-4:
            continue
        tints = [0.2 + 0.1 * k for k, d in enumerate(exact) if d < nearest + 1e-4]
        assert any(colour[ray] == pytest.approx(tint) for tint in tints)


@given(specs, scenes)
@settings(max_examples=100, deadline=None)
def test_a_mirrored_scene_gives_the_mirrored_retina(
    spec: RetinaSpec, scene: list[Obstacle]
) -> None:
    mirrored = [dataclasses.replace(obstacle, y_m=-obstacle.y_m) for obstacle in scene]
    distance, _ = seen(spec, scene)
    mirror, _ = seen(spec, mirrored)
    # The cosines of +φ and −φ are equal to the bit; those of a bearing and its mirror nearly are.
    grazed = [any(ambiguous(o, b) for o in scene) for b in bearings(spec)]
    clear = ~np.array(grazed)
    np.testing.assert_allclose(distance[clear], mirror[::-1][clear], atol=2e-5)


def test_index_0_is_the_leftmost_ray() -> None:
    distance, _ = seen(RetinaSpec(), [Obstacle(0.3, 2.0, 0.3, 0.3, False)])
    assert distance.argmin() <= 1
    assert (distance[8:] == 5.0).all()


@given(
    st.floats(0.0, 1.0), st.floats(0.0, 8.0), st.sampled_from([0.4, 5.0]), st.sampled_from(Shading)
)
@settings(deadline=None)
def test_a_value_is_the_runtime_s_own_formula(
    colour: float, distance: float, range_m: float, shading: Shading
) -> None:
    values = np.zeros(1, np.uint8)
    tint, length = np.array([colour], np.float32), np.array([distance], np.float32)
    nearness = shading is Shading.NEARNESS
    shade_all(range_m, nearness, length, tint, values)
    assert values[0] == retina.shade(float(tint[0]), float(length[0]), range_m, nearness)


@pytest.mark.parametrize("world", ["reference-1", "mixed", "legacy"])
@pytest.mark.parametrize("fov_rad", [math.pi, 2 * math.pi])
def test_everything_in_reach_is_seen_wherever_the_agent_has_gone(
    world: str, fov_rad: float
) -> None:
    """Against every obstacle of the chunks around, in all periods: the near list forgets none."""
    contract = PolicyContract(retina=RetinaSpec(rays=12, fov_rad=fov_rad))
    simulation = Simulation(world_named(world), contract, test_seeds(4))
    generator = np.random.default_rng(1)
    for _ in range(8):
        values = simulation.sense()[:, 0, :, 0]
        for agent in range(4):
            expected = slow_retina(simulation, agent)
            assert np.abs(values[agent].astype(int) - expected).max() <= 1
        for _ in range(9):
            simulation.step(generator.integers(0, 3, 4))


def slow_retina(simulation: Simulation, agent: int) -> npt.NDArray[np.int64]:
    spec = simulation.contract.retina
    x_m, y_m = float(simulation.x_m[agent]), float(simulation.y_m[agent])
    scene = obstacles_around(simulation, agent)
    values = []
    for bearing in bearings(spec):
        nearest = min((distance_m(o, x_m, y_m, bearing) for o in scene), default=math.inf)
        values.append(retina.shade(1.0, nearest, spec.range_m, True))
    return np.array(values)
