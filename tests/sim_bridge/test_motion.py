import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract import PolicyContract, RetinaSpec, sideways_actions
from reflexarc_sim_bridge import kernel
from reflexarc_sim_bridge.motion import free_share, is_free
from reflexarc_sim_bridge.params import NEAR_ROWS
from reflexarc_sim_bridge.seeds import test_seeds
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.world_files import world_named
from reflexarc_sim_bridge.worlds import Discs, World
from support.slow_geometry import Obstacle
from support.slow_world import obstacles_around

places = st.floats(-2.0, 2.0).map(lambda v: round(v, 3))
halves = st.floats(0.05, 1.0).map(lambda v: round(v, 3))
rectangles = st.builds(Obstacle, places, places, halves, halves, st.just(False))
discs = st.builds(lambda x, y, r: Obstacle(x, y, r, r, True), places, places, halves)
scenes = st.lists(rectangles | discs, min_size=1, max_size=4)
steps = st.sampled_from([0.0, 1.0, -1.0, 0.37, 2.5])


def share_of(scene: list[Obstacle], forward_m: float, aside_m: float) -> float:
    near = np.zeros((NEAR_ROWS, len(scene)))
    for k, o in enumerate(scene):
        near[:, k] = (o.x_m, o.y_m, o.half_length_m, o.half_width_m, o.disc, 1.0)
    return free_share(near, len(scene), 0.0, 0.0, forward_m, aside_m)


def grown(scene: list[Obstacle], by_m: float) -> list[Obstacle]:
    return [
        dataclasses.replace(
            o, half_length_m=o.half_length_m + by_m, half_width_m=o.half_width_m + by_m
        )
        for o in scene
    ]


@given(scenes, steps, steps)
@settings(max_examples=300, deadline=None)
def test_contacts_along_a_step_agree_with_dense_sampling(
    scene: list[Obstacle], forward_m: float, aside_m: float
) -> None:
    shares = np.linspace(0.0, 1.0, 1001)
    inside = [any(o.covers(s * forward_m, s * aside_m) for o in scene) for s in shares]
    first = float(shares[inside.index(True)]) if any(inside) else math.inf
    found = share_of(scene, forward_m, aside_m)
    if math.isfinite(found):
        # What is met is there: the place found touches an obstacle, and none lies before it.
        assert any(o.covers(found * forward_m, found * aside_m) for o in grown(scene, 1e-6))
        assert found <= first + 1e-9
        before = shares[shares < found - 1e-6]
        assert not any(o.covers(s * forward_m, s * aside_m, 1e-6) for o in scene for s in before)
    else:
        assert not any(inside)


@given(scenes)
@settings(max_examples=100, deadline=None)
def test_who_stands_still_outside_meets_nothing(scene: list[Obstacle]) -> None:
    touching = any(o.covers(0.0, 0.0) for o in grown(scene, 1e-6))
    inside = any(o.covers(0.0, 0.0, 1e-6) for o in scene)
    if touching == inside:
        assert share_of(scene, 0.0, 0.0) == (0.0 if inside else math.inf)


@pytest.mark.parametrize("world", ["reference-1", "mixed", "legacy"])
def test_the_ray_straight_ahead_says_when_a_contact_comes(world: str) -> None:
    # One ray, bearing 0, and an agent that goes straight: eye and body share one geometry.
    contract = PolicyContract(retina=RetinaSpec(rays=1, fov_rad=1.0), actions=sideways_actions())
    simulation = Simulation(world_named(world), contract, test_seeds(64))
    blind, checked = np.zeros(64, np.int64), 0
    for _ in range(300):
        simulation.sense()
        ahead_m = simulation.params.agents.ray_distance_m[:, 0].astype(float)
        before_m = simulation.distance_m.copy()
        met = simulation.step(blind)
        certain = np.abs(ahead_m - 0.1) > 1e-5
        np.testing.assert_array_equal(met[certain], (ahead_m < 0.1)[certain])
        travelled_m = simulation.distance_m - before_m
        np.testing.assert_allclose(travelled_m[met], ahead_m[met], atol=1e-5)
        np.testing.assert_allclose(travelled_m[~met], 0.1, atol=1e-12)
        checked += int(met.sum())
    assert checked > 200


@pytest.mark.parametrize("world", ["reference-1", "mixed", "legacy"])
def test_nobody_ever_stands_inside_an_obstacle(world: str) -> None:
    simulation = Simulation(world_named(world), PolicyContract(), test_seeds(8))
    generator = np.random.default_rng(0)
    for _ in range(40):
        for _ in range(5):
            simulation.step(generator.integers(0, 3, 8))
        for i in range(8):
            scene = obstacles_around(simulation, i, chunks=1)
            x_m, y_m = float(simulation.x_m[i]), float(simulation.y_m[i])
            assert not any(o.covers(x_m, y_m, 1e-9) for o in scene)


def test_a_contact_moves_an_agent_aside_and_not_ahead() -> None:
    simulation = Simulation(world_named("reference-1"), PolicyContract(), test_seeds(256))
    x_m, y_m = simulation.x_m.copy(), simulation.y_m.copy()
    met = np.zeros(256, np.bool_)
    while not met.any():
        x_m, y_m = simulation.x_m.copy(), simulation.y_m.copy()
        met = simulation.step(np.zeros(256, np.int64))
    assert (simulation.x_m[met] - x_m[met] <= 0.1).all()
    assert (np.abs(simulation.y_m[met] - y_m[met]) > 0.0).all()
    np.testing.assert_array_equal(simulation.y_m[~met], y_m[~met])
    np.testing.assert_array_equal(simulation.contacts, met)


def test_places_after_a_contact_are_uniform_among_the_free() -> None:
    """Of all free places of one line, each twentieth is drawn as often as it is long."""
    world = world_named("reference-1")
    simulation = Simulation(world, PolicyContract(), np.full(20_000, 11, np.uint64))
    params, _, agents = simulation.params
    grid_m = (np.arange(20_000) + 0.5) / 1000.0
    free = np.array([is_free(params, np.uint64(11), 0.0, float(y)) for y in grid_m])
    expected = np.histogram(grid_m[free], bins=20, range=(0.0, 20.0))[0] / free.sum()
    found = np.histogram(agents.y_m, bins=20, range=(0.0, 20.0))[0] / 20_000
    assert np.abs(found - expected).max() < 4.5 * math.sqrt(0.05 * 0.95 / 20_000)


def test_open_edges_stop_sideways_motion_and_periodic_ones_wrap_it() -> None:
    left = np.ones(16, np.int64)
    for name, low_m in (("legacy", 0.0), ("reference-1", 0.0)):
        empty = dataclasses.replace(world_named(name), density_per_m2=0.0)
        simulation = Simulation(empty, PolicyContract(), test_seeds(16))
        start_m = simulation.y_m.copy()
        for _ in range(250):
            simulation.step(left)
        moved_m = start_m + 25.0
        wanted = np.full(16, 12.0) if name == "legacy" else moved_m % 20.0 + low_m
        np.testing.assert_allclose(simulation.y_m, wanted, atol=1e-9)


def blind_rate(world: World, agents: int, steps_: int) -> tuple[float, float]:
    """Contacts per 100 m of agents that never steer, and its standard error."""
    simulation = Simulation(world, PolicyContract(), test_seeds(agents))
    params, _, state = simulation.params
    zeros, met = np.zeros(agents, np.int64), np.zeros(agents, np.bool_)
    for _ in range(steps_):
        kernel.step_all(params, state, np.ones(1), np.zeros(1), zeros, met)
    contacts = simulation.contacts.sum()
    rate = 100.0 * contacts / simulation.distance_m.sum()
    return float(rate), float(rate / np.sqrt(contacts))


def test_a_blind_agent_meets_two_rho_r_rectangles_a_metre() -> None:
    # 600 agents over 100 m: 21,000 contacts, so 0.7 % at one sigma: twice that is the 1.5 % bias
    # that counting a contact's whole step would make.
    rate, error = blind_rate(world_named("reference-1"), 600, 1000)
    assert error < 0.27
    assert rate == pytest.approx(36.0, abs=2.5 * error)


def test_a_blind_agent_meets_two_rho_r_discs_a_metre() -> None:
    # In a wide world: in 20 m, one place in 29 lies beside the disc just met and meets it again.
    wide = World("wide", width_m=60.0, density_per_m2=0.2, shapes=(Discs(radius_m=(0.2, 0.4)),))
    rate, error = blind_rate(wide, 400, 1500)
    assert error < 0.15
    assert rate == pytest.approx(100 * 0.2 * 2 * 0.3, abs=3 * error)
