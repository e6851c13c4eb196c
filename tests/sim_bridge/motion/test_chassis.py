import dataclasses
import math

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.obstacles.kinds.corridor import WALL_THICKNESS_M
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Corridor, Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, Edges, World
from support.slow_geometry import Floats
from support.slow_world import outlines_around

EMPTY = World("empty", layers=())
PLANE = dataclasses.replace(EMPTY, edges=Edges.UNBOUNDED)
DRIVEN = PolicyContract(
    retina=RetinaSpec(rays=2, range_m=1.0),
    actions=(Action("ahead", 2.0, 1.0), Action("turn", 1.0, 0.0, 0.7)),
)


def one(world: World, contract: PolicyContract = DRIVEN) -> Simulation:
    return Simulation(world, contract, test_seeds(1))


def many(chassis: Chassis, agents: int = 4096) -> Simulation:
    return Simulation(dataclasses.replace(PLANE, chassis=chassis), DRIVEN, test_seeds(agents))


# Speeds


def test_a_body_goes_straight_at_its_speeds() -> None:
    simulation = one(PLANE)
    y_m = float(simulation.y_m[0])
    for _ in range(100):
        assert not simulation.drive(2.0, -1.0, 0.0)
    assert simulation.x_m[0] == pytest.approx(20.0, abs=1e-9)
    assert simulation.y_m[0] - y_m == pytest.approx(-10.0, abs=1e-9)
    assert (simulation.heading_rad[0], simulation.distance_m[0]) == (0.0, pytest.approx(20.0))


@pytest.mark.parametrize(("linear_mps", "angular_radps"), [(1.0, 0.7), (2.0, -3.0), (0.5, 31.0)])
def test_a_turning_body_ends_every_step_on_the_exact_arc(
    linear_mps: float, angular_radps: float
) -> None:
    simulation = one(PLANE)
    y_m, radius_m = float(simulation.y_m[0]), linear_mps / angular_radps
    for step in range(1, 60):
        simulation.drive(linear_mps, 0.0, angular_radps)
        turned_rad = angular_radps * 0.1 * step
        assert simulation.x_m[0] == pytest.approx(radius_m * math.sin(turned_rad), abs=1e-9)
        above_m = radius_m * (1.0 - math.cos(turned_rad))
        assert simulation.y_m[0] - y_m == pytest.approx(above_m, abs=1e-9)
        heading_rad = float(simulation.heading_rad[0])
        assert math.remainder(heading_rad - turned_rad, math.tau) == pytest.approx(0.0, abs=1e-9)
        assert -math.pi <= heading_rad <= math.pi
    assert simulation.distance_m[0] == pytest.approx(simulation.x_m[0], abs=1e-9)


def test_sideways_speed_is_in_the_body_s_own_frame() -> None:
    simulation = one(PLANE)
    simulation.params.agents.state["heading_rad"] = math.pi / 2
    y_m = float(simulation.y_m[0])
    simulation.drive(1.0, 2.0, 0.0)
    assert simulation.x_m[0] == pytest.approx(-0.2)
    assert simulation.y_m[0] - y_m == pytest.approx(0.1)


def test_speeds_follow_a_command_exponentially_where_they_lag() -> None:
    simulation = one(dataclasses.replace(PLANE, chassis=Chassis(lag_s=0.4)))
    for step in range(1, 30):
        simulation.drive(2.0, -1.0, 0.5)
        follows = 1.0 - math.exp(-0.1 * step / 0.4)
        state = simulation.params.agents.state[0]
        speeds = (state["linear_mps"], state["lateral_mps"], state["angular_radps"])
        assert speeds == pytest.approx((2.0 * follows, -1.0 * follows, 0.5 * follows))


def test_speeds_change_no_faster_than_they_can() -> None:
    chassis = Chassis(acceleration_mps2=2.0, turn_acceleration_radps2=1.0)
    simulation = one(dataclasses.replace(PLANE, chassis=chassis))
    for step in range(1, 30):
        simulation.drive(2.0, -1.0, 0.5)
        state = simulation.params.agents.state[0]
        assert state["linear_mps"] == pytest.approx(min(0.2 * step, 2.0))
        assert state["lateral_mps"] == pytest.approx(-min(0.2 * step, 1.0))
        assert state["angular_radps"] == pytest.approx(min(0.1 * step, 0.5))
    wanted_m = sum(min(0.2 * step, 2.0) for step in range(1, 4)) * 0.1
    straight = one(dataclasses.replace(PLANE, chassis=chassis))
    for _ in range(3):
        straight.drive(2.0, 0.0, 0.0)
    assert straight.distance_m[0] == pytest.approx(wanted_m)


def test_slip_has_its_standard_deviation_in_every_speed_and_no_bias() -> None:
    simulation = many(Chassis(slip=0.2))
    y_m = simulation.y_m
    simulation.step(np.zeros(4096, np.int64))
    ahead, left = simulation.distance_m / 0.2 - 1.0, (simulation.y_m - y_m) / 0.1 - 1.0
    for share in (ahead, left):
        assert share.mean() == pytest.approx(0.0, abs=4 * 0.2 / 64)
        assert share.std() == pytest.approx(0.2, rel=4 / math.sqrt(2 * 4096))
        assert ((share / 0.2) ** 4).mean() == pytest.approx(3.0, abs=4 * math.sqrt(96 / 4096))
    assert abs(np.corrcoef(ahead, left)[0, 1]) < 4 / 64
    turning = many(Chassis(slip=0.2))
    turning.step(np.ones(4096, np.int64))
    turned = turning.heading_rad / 0.07 - 1.0
    assert turned.mean() == pytest.approx(0.0, abs=4 * 0.2 / 64)
    assert turned.std() == pytest.approx(0.2, rel=4 / math.sqrt(2 * 4096))


def test_slip_is_drawn_anew_at_every_step() -> None:
    simulation = many(Chassis(slip=0.2))
    simulation.step(np.zeros(4096, np.int64))
    first_m = simulation.distance_m.copy()
    simulation.step(np.zeros(4096, np.int64))
    assert abs(np.corrcoef(first_m, simulation.distance_m - first_m)[0, 1]) < 4 / 64


@pytest.mark.parametrize("rate_hz", [10, 50, 4])
def test_after_a_second_a_body_that_slips_is_off_as_much_at_any_rate(rate_hz: int) -> None:
    """In n steps of 1/n s a share s is off by v s √n / n; 0.2 at ten of them is v 0.2 / √10."""
    agents, chassis = 8192, Chassis(slip=0.2)
    world = dataclasses.replace(PLANE, chassis=chassis, dt_s=1.0 / rate_hz)
    straight, turning = (Simulation(world, DRIVEN, test_seeds(agents)) for _ in range(2))
    y_m = straight.y_m
    for _ in range(rate_hz):
        straight.step(np.zeros(agents, np.int64))
        turning.step(np.ones(agents, np.int64))
    left_m = straight.y_m - y_m
    ways = ((straight.distance_m, 2.0), (left_m, 1.0), (turning.heading_rad, 0.7))
    for way, speed in ways:
        off = 0.2 / math.sqrt(10) * speed
        assert way.mean() == pytest.approx(speed, abs=4 * off / math.sqrt(agents))
        assert way.std() == pytest.approx(off, rel=4 / math.sqrt(2 * agents))


# Sides


def test_open_edges_stop_sideways_motion_and_periodic_ones_wrap_it() -> None:
    for edges in (Edges.OPEN, Edges.PERIODIC, Edges.UNBOUNDED):
        world = dataclasses.replace(EMPTY, edges=edges, width_m=12.0)
        simulation = Simulation(world, DRIVEN, test_seeds(16))
        y_m = simulation.y_m
        for _ in range(250):
            simulation.step(np.zeros(16, np.int64))
        wanted = {Edges.OPEN: np.full(16, 12.0), Edges.PERIODIC: (y_m + 25.0) % 12.0}
        np.testing.assert_allclose(simulation.y_m, wanted.get(edges, y_m + 25.0), atol=1e-9)


@pytest.mark.parametrize("radius_m", [0.0, 0.3])
@pytest.mark.parametrize(
    "corridor",
    [
        Corridor(),
        Corridor(width_m=3.0, meander_m=2.5, wavelength_m=5.0),
        Corridor(width_m=4.0, meander_m=10.0, wavelength_m=20.0),
        Corridor(width_m=1.0, meander_m=0.0),
    ],
)
def test_agents_never_leave_a_corridor(corridor: Corridor, radius_m: float) -> None:
    chassis, clutter = Chassis(radius_m=radius_m), Scatter(density_per_m2=0.05)
    world = World("walls", edges=Edges.UNBOUNDED, layers=(corridor, clutter), chassis=chassis)
    actions = (Action("a", 1.0, 4.0), Action("b", 2.0, -4.0), Action("c", 3.0, 0.0))
    contract = PolicyContract(retina=RetinaSpec(rays=2, range_m=0.4), actions=actions)
    simulation, generator = Simulation(world, contract, test_seeds(32)), np.random.default_rng(4)
    for _ in range(20):
        for agent in range(0, 32, 8):
            around = outlines_around(simulation, agent, corridor.width_m + 2.0)
            walls = [o for o in around if o.layer == 0]
            low_m, high_m = between_walls_m(walls, float(simulation.x_m[agent]))
            assert high_m - low_m == pytest.approx(corridor.width_m, abs=1e-6)
            assert low_m <= simulation.y_m[agent] <= high_m
        held = generator.integers(0, 3, 32)
        for _ in range(10):
            simulation.step(held)
    assert simulation.contacts.sum() > 32


def between_walls_m(walls: list[Outline], x_m: float) -> tuple[float, float]:
    """Upper face of the right wall and lower face of the left one, at some x."""
    spans_m = sorted(span for wall in walls if (span := span_at(wall.corners_m, x_m)))
    assert all(high - low == pytest.approx(WALL_THICKNESS_M) for low, high in spans_m)
    return spans_m[0][1], spans_m[-1][0]


def span_at(corners_m: Floats, x_m: float) -> tuple[float, float] | None:
    """Where a line across cuts a convex polygon."""
    cuts = []
    for (x, y), (end_x, end_y) in zip(corners_m, np.roll(corners_m, -1, axis=0), strict=True):
        if min(x, end_x) <= x_m <= max(x, end_x) and x != end_x:
            cuts.append(float(y + (x_m - x) / (end_x - x) * (end_y - y)))
    return (min(cuts), max(cuts)) if cuts else None


def test_a_wholly_blocked_line_lets_the_agent_through_without_counting_the_way() -> None:
    tiny = Rectangles(width_m=(0.2, 0.5), length_m=(0.2, 0.5))
    crowded = World("crowded", width_m=1.0, layers=(Scatter(density_per_m2=12.0, shapes=(tiny,)),))
    simulation = Simulation(crowded, DRIVEN, test_seeds(64))
    for _ in range(300):
        simulation.step(np.zeros(64, np.int64))
    assert np.isfinite(simulation.y_m).all()
    assert (simulation.x_m > simulation.distance_m + 0.05).any()
    assert (simulation.x_m > 5.0).all()
