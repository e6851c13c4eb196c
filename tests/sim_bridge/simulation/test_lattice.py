"""What is met on a lattice is what an agent meets that is put there and moved."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_sim_bridge.arrays.layout import GHOST
from reflexarc_sim_bridge.evaluation.cover_profile import right_side_m
from reflexarc_sim_bridge.evaluation.limits.rows import bare, blocks_back, rows_of
from reflexarc_sim_bridge.simulation.lattice import COVERED
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.layers import Corridor, Drift, Scatter, Swing
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, Edges, World

SHAPES = (Rectangles(), Rectangles(turned_rad=(0.2, 0.9)), Discs(), Curves(), Polygons())
DENSE = Scatter(density_per_m2=0.5, shapes=SHAPES)
WORLDS = {
    "at rest": World("rest", width_m=7.5, layers=(DENSE,)),
    "large": World("large", width_m=12.5, layers=(Scatter(0.03, shapes=(Polygons((2.0, 3.0)),)),)),
    "drifting": World(
        "drift", width_m=7.5, layers=(DENSE, replace(DENSE, motion=Drift(-0.7, 0.4)))
    ),
    "swinging": World("swing", width_m=7.5, layers=(replace(DENSE, motion=Swing(0.5, 1.0)),)),
    "open": World("open", width_m=6.0, edges=Edges.OPEN, layers=(Scatter(0.5),)),
    "corridor": World(
        "corridor",
        width_m=4.0,
        edges=Edges.UNBOUNDED,
        layers=(Corridor(width_m=4.0), Scatter(0.3)),
    ),
    "automaton": replace(world_named("automaton").drawn(0), width_m=5.0),
}
CONTRACT = PolicyContract(actions=sideways_actions(1.0, 0.5))
STEPS, SEED = 90, 5


def found_on(world, contract):
    rows = rows_of(world, contract, STEPS)
    found = np.empty((STEPS, len(rows.rows_m)), np.uint8)
    for first, block in blocks_back(world, SEED, rows, STEPS):
        found[first : first + len(block)] = block
    return rows, found


def met_in(world, rows, n):
    """The bits of every row at step n, by ghosts that are put there and moved."""
    actions = [
        Action(str(k), rows.ahead_m / world.dt_s, left / world.dt_s)
        for k, left in enumerate(rows.left_m)
    ]
    contract = PolicyContract(actions=(*actions, Action("stand", 0.0, 0.0)))
    simulation = Simulation(world, contract, np.full(len(rows.rows_m), SEED, np.uint64))
    planes, agents = simulation.params.world.planes, simulation.params.agents
    planes["after_contact"] = GHOST
    state, side_m, x_m = agents.state, planes["chunk_width_m"][0], n * rows.ahead_m
    state["cell_x"], state["cell_y"] = x_m // CHUNK_M, rows.rows_m // side_m
    state["x_m"] = x_m - state["cell_x"] * CHUNK_M
    state["y_m"] = rows.rows_m - state["cell_y"] * side_m
    state["steps"], state["is_inside"] = n - 1, True
    agents.layer_cells[:] = -(1 << 62)
    # Who stands for a step lists what is near, and says whether it is still in something.
    simulation.step(np.full(len(state), len(actions)))
    bits = np.where(state["is_inside"], COVERED, 0).astype(np.uint8)
    state["is_inside"] = False
    before = simulation.state()
    for k in range(len(actions)):
        simulation.restore(before)
        bits |= simulation.step(np.full(len(state), k)).astype(np.uint8) << k
    return np.where(bits & COVERED, COVERED, bits)


def is_between_walls(world, rows, n):
    if world.corridor is None:
        return np.ones(len(rows.rows_m), np.bool_)
    half_m, x_m = world.corridor.width_m / 2, np.array([n * rows.ahead_m])
    chunks_m = np.floor(x_m / CHUNK_M) * CHUNK_M
    ends_m = [
        right_side_m(world, SEED, at) + world.corridor.width_m / 2 - 0.1
        for at in (chunks_m, chunks_m + CHUNK_M)
    ]
    share = (x_m - chunks_m) / CHUNK_M
    middle_m = (1.0 - share) * ends_m[0] + share * ends_m[1]
    return np.abs(rows.rows_m - middle_m) <= half_m


@pytest.mark.parametrize("radius_m", [0.0, 0.25])
@pytest.mark.parametrize("name", WORLDS)
def test_a_lattice_says_what_agents_meet_that_are_put_there(name, radius_m):
    world = replace(bare(WORLDS[name]), chassis=Chassis(radius_m=radius_m))
    rows, found = found_on(world, CONTRACT)
    assert (found == COVERED).any()
    assert ((found > 0) & (found < 7)).any() or name == "automaton"
    for n in range(1, STEPS, 6):
        expected = np.where(is_between_walls(world, rows, n), met_in(world, rows, n), COVERED)
        np.testing.assert_array_equal(found[n], expected)
