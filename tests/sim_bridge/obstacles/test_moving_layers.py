import math

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Drift, Motion, Scatter, Swing
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.slow_world import displaced_m, outlines_around

FIELD = (Rectangles(), Discs(), Polygons())
STANDING = PolicyContract(
    retina=RetinaSpec(rays=8, range_m=3.0),
    actions=(Action("stand", 0.0, 0.0), Action("turn", 0.0, 0.0, 1.0)),
)


def at_time(motion: Motion, steps: int) -> tuple[Simulation, list[Outline]]:
    """A point that has been carried along with nothing, and what is near it at a time."""
    layer = Scatter(density_per_m2=0.2, shapes=FIELD, motion=motion)
    world = World("moving", layers=(layer,), edges=Edges.UNBOUNDED)
    simulation = Simulation(world, STANDING, test_seeds(1))
    state = simulation.params.agents.state
    state["cell_x"], state["cell_y"], state["x_m"], state["y_m"] = 0, 0, 1.0, 1.0
    state["steps"] = steps - 1
    simulation.params.agents.layer_cells[:] = 1 << 40
    state["is_inside"] = 1  # it meets nothing on the way to its next list
    simulation.drive(0.0, 0.0, 0.0)
    state["is_inside"] = 0
    return simulation, simulation.outlines_near(0)


def key(outline: Outline) -> tuple[int, int]:
    return round(outline.x_m * 1e4), round(outline.y_m * 1e4)


@pytest.mark.parametrize("motion", [Drift(-1.5, 0.4), Drift(0.0, -7.0), Swing(0.5, 2.0, 3.0)])
@pytest.mark.parametrize("steps", [0, 13, -13, 100_000, -100_000])
def test_obstacles_of_a_moving_layer_are_where_the_closed_form_says(
    motion: Motion, steps: int
) -> None:
    simulation, near = at_time(motion, steps)
    around = outlines_around(simulation, 0, 3.0)
    for outline in around:
        if math.hypot(outline.x_m - 1.0, outline.y_m - 1.0) < 3.0:
            distances = [math.hypot(o.x_m - outline.x_m, o.y_m - outline.y_m) for o in near]
            assert min(distances) < 1e-5
    assert len(near) > 5


@pytest.mark.parametrize("motion", [Drift(-1.5, 0.4), Swing(0.5, 2.0, 3.0)])
def test_backwards_in_time_a_layer_moves_the_other_way(motion: Motion) -> None:
    """The same obstacle, seen at t and at −t, has moved by as much to either side."""
    sides = []
    for steps in (4, -4):
        ahead_m, left_m = displaced_m(motion, 0.1 * steps)
        near = at_time(motion, steps)[1]
        sides.append({(round(o.x_m - ahead_m, 4), round(o.y_m - left_m, 4)): o for o in near})
    both = sides[0].keys() & sides[1].keys()
    assert len(both) > 5
    moved_m = np.array(displaced_m(motion, 0.4))
    for k in both:
        after, before = ((s[k].x_m, s[k].y_m) for s in sides)
        np.testing.assert_allclose(np.subtract(after, before), 2 * moved_m, atol=1e-4)


def test_a_swing_returns_after_its_period() -> None:
    swing = Swing(0.7, 1.3, 2.0)
    first, later = (at_time(swing, steps)[0] for steps in (3, 3 + 20 * 50))
    assert first.sense().tobytes() == later.sense().tobytes()
    assert first.sense().any()
    half = at_time(swing, 13)[0]
    assert first.sense().tobytes() != half.sense().tobytes()


def test_layers_move_each_in_its_own_way_and_the_world_of_a_standing_agent_changes() -> None:
    layers = (Scatter(density_per_m2=0.2), Scatter(density_per_m2=0.2, motion=Drift(-2.0, 0.0)))
    simulation = Simulation(
        World("two", layers=layers, edges=Edges.UNBOUNDED), STANDING, test_seeds(1)
    )
    near = [(o.layer, *key(o)) for o in simulation.outlines_near(0)]
    simulation.drive(0.0, 0.0, 0.0)
    later = {(o.layer, *key(o)) for o in simulation.outlines_near(0)}
    rest = [k for k in near if k[0] == 0]
    assert simulation.contacts[0] or later.issuperset(rest)
    drifted = [(1, x_m - 2000, y_m) for layer, x_m, y_m in near if layer == 1]
    assert sum(k in later for k in drifted) > 5


def test_a_stream_of_obstacles_hits_a_standing_agent_as_often_as_it_would_meet_them() -> None:
    """At rest in a field that drifts towards it at v, an agent is hit 2ρRv times a second."""
    layer = Scatter(density_per_m2=0.2, motion=Drift(-5.0, 0.0))
    simulation = Simulation(World("stream", layers=(layer,)), STANDING, test_seeds(512))
    for _ in range(200):
        simulation.step(np.zeros(512, np.int64))
    hits = int(simulation.contacts.sum())
    # Time goes on after a contact: what would have come in the rest of its step is not met.
    met_per_m, step_m = 0.2 * 0.9, 0.5
    expected = met_per_m * 100.0 * 512 / (1.0 + met_per_m * step_m / 2)
    assert hits == pytest.approx(expected, abs=4 * math.sqrt(expected))
