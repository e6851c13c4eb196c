"""The oracle against plain recursion, against all sequences of motions, and against who drives."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.arrays.layout import GHOST
from reflexarc_sim_bridge.evaluation.driving.drive import Extent, drive
from reflexarc_sim_bridge.evaluation.limits.oracle import (
    least_contacts,
    oracle_sums,
    values_at_start,
)
from reflexarc_sim_bridge.evaluation.limits.rows import bare, blocks_back, rows_of
from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.simulation.lattice import COVERED
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Corridor, Drift, Scatter
from reflexarc_sim_bridge.worlds.world import Edges, World

CONTRACT = PolicyContract(actions=sideways_actions(1.0, 0.5))
CELL = SuiteCell("0.20", "reference-1", clutter=0.2)
FAMILIES = (SuiteFamily("f", cells=(CELL,)),)
SUITE = Suite("tiny", 1, worlds=4, lanes=16, free_paths=15.0, families=FAMILIES)
RIVALS = (BLIND, "random", "reflexarc_baselines.anchors.braitenberg:Braitenberg2a")
NARROW = World("narrow", width_m=2.5, layers=(Scatter(0.9),))
DRIFTING = replace(NARROW, layers=(Scatter(0.6), Scatter(0.4, motion=Drift(-0.5, 0.7))))
LOOSE = replace(DRIFTING, layers=(Scatter(0.3), Scatter(0.2, motion=Drift(-0.5, 0.7))))
WALLED = World(
    "walled", width_m=3.0, edges=Edges.UNBOUNDED, layers=(Corridor(3.0, 1.0, 10.0), Scatter(0.6))
)
PLANE = World("plane", width_m=3.0, edges=Edges.UNBOUNDED, layers=(Scatter(0.6),))
OPEN = World("open", width_m=3.0, edges=Edges.OPEN, layers=(Scatter(0.6),))


def all_found(world, rows, steps, seed):
    found = np.empty((steps, len(rows.rows_m)), np.uint8)
    for first, block in blocks_back(world, seed, rows, steps):
        found[first : first + len(block)] = block
    return found


def slow_values(world, rows, extent, seed):
    """V at the start of each row, by the definition and nothing else."""
    steps, n_rows = extent.discarded + extent.counted, len(rows.rows_m)
    found = all_found(world, rows, steps, seed)
    values = [0.0] * n_rows
    anew = [0.0] * n_rows
    for n in reversed(range(steps)):
        before = [math.inf] * n_rows
        for row in range(n_rows):
            if found[n, row] == COVERED:
                continue
            for k, shift in enumerate(rows.shifts.tolist()):
                to = (row + shift) % n_rows if rows.wraps else min(max(row + shift, 0), n_rows - 1)
                met = (n >= extent.discarded) + anew[row]
                value = met if found[n, row] >> k & 1 or values[to] == math.inf else values[to]
                before[row] = min(before[row], value)
        values = before
        for row in range(n_rows):
            near = range(n_rows)
            if rows.window:
                near = range(max(0, row - rows.window), min(n_rows, row + rows.window + 1))
            free = [values[other] for other in near if values[other] < math.inf]
            anew[row] = math.fsum(free) / len(free) if free else anew[row]
    return np.array(values), np.array(anew)


@pytest.mark.parametrize("world", [NARROW, DRIFTING, WALLED, PLANE, OPEN], ids=lambda w: w.name)
def test_values_are_those_of_plain_recursion(world):
    extent, dt_s = Extent(discarded=10, counted=40), 0.2
    world = bare(replace(world, dt_s=dt_s))
    rows = rows_of(world, CONTRACT, 50)
    values = values_at_start(world, 3, rows, extent)
    least, anew = slow_values(world, rows, extent, 3)
    np.testing.assert_allclose(values.least, least, rtol=1e-9)
    np.testing.assert_allclose(values.anew, anew, rtol=1e-9)
    assert np.isfinite(least).any()


def puts_on(world, contract, rows_m, copies):
    """Agents on rows, each as often as there are copies, ready to go."""
    seeds = np.full(len(rows_m) * copies, 3, np.uint64)
    simulation = Simulation(world, contract, seeds)
    planes, agents = simulation.params.world.planes, simulation.params.agents
    planes["after_contact"] = GHOST
    state, side_m = agents.state, planes["chunk_width_m"][0]
    y_m = np.repeat(rows_m, copies)
    state["cell_x"], state["x_m"] = 0, 0.0
    state["cell_y"] = y_m // side_m
    state["y_m"] = y_m - state["cell_y"] * side_m
    state["steps"], state["is_inside"] = -1, True
    agents.layer_cells[:] = -(1 << 62)
    simulation.step(np.full(len(state), len(contract.actions) - 1))
    return simulation


def test_a_row_is_free_of_cost_exactly_where_one_of_all_sequences_meets_nothing():
    steps, world = 8, bare(replace(LOOSE, dt_s=0.4))
    rows = rows_of(world, CONTRACT, steps)
    values = values_at_start(world, 3, rows, Extent(0, steps)).least
    chosen = np.flatnonzero(np.isfinite(values))[::6]
    sequences = np.array(list(itertools.product(range(3), repeat=steps)))
    left_mps = (rows.left_m / world.dt_s).tolist()
    actions = [Action(str(k), 1.0, left) for k, left in enumerate(left_mps)]
    contract = PolicyContract(actions=(*actions, Action("stand", 0.0, 0.0)))
    simulation = puts_on(world, contract, rows.rows_m[chosen], len(sequences))
    assert not simulation.params.agents.state["is_inside"].any()
    met = np.zeros(len(simulation), np.bool_)
    for n in range(steps):
        met |= simulation.step(np.tile(sequences[:, n], len(chosen)))
    is_free = ~met.reshape(len(chosen), len(sequences)).all(axis=1)
    np.testing.assert_array_equal(values[chosen] == 0.0, is_free)
    assert is_free.any()
    assert not is_free.all()


def test_an_oracle_that_cannot_steer_is_a_blind_agent():
    ahead = tuple(Action(name, 1.0, 0.0) for name in ("stay", "also"))
    contender = Contender(BLIND, BlindPolicy(2), PolicyContract(actions=ahead))
    suite = replace(SUITE, lanes=64)
    expected = oracle_sums(contender, CELL, suite, Setting.FIELD)
    driven = sums_of(drive(contender, CELL, suite, Setting.FIELD))
    # A contact of the oracle's takes the rest of its step, one half on average: it has fewer.
    rate, own = (s["contacts"].sum() / s["progress_m"].sum() for s in (driven, expected))
    lost = 1.0 - 0.05 * rate
    assert own == pytest.approx(rate * lost, abs=3.5 * rate / math.sqrt(driven["contacts"].sum()))


@pytest.mark.parametrize("source", RIVALS)
def test_nobody_beats_the_oracle(source):
    contender = contender_of(source)
    oracle = oracle_sums(contender, CELL, SUITE, Setting.FIELD)
    driven = sums_of(drive(contender, CELL, SUITE, Setting.FIELD))
    own = driven["contacts"]
    assert (own + 3.5 * np.sqrt(own + 1.0) >= oracle["contacts"]).all()
    assert own.sum() > 2.0 * oracle["contacts"].sum() > 0.0


def test_a_higher_rate_is_never_a_disadvantage():
    world = bare(World("reference", layers=(Scatter(0.9),)))
    contract = PolicyContract(actions=sideways_actions(1.0, 1.0))
    slow, quick = (
        least_contacts(replace(world, dt_s=dt_s), 1, contract, Extent(0, round(20.0 / dt_s)))
        for dt_s in (0.2, 0.04)
    )
    assert quick <= slow


@pytest.mark.parametrize(
    "actions",
    [
        (Action("ahead", 1.0, 0.0), Action("stop", 0.0, 0.0)),
        (Action("ahead", 1.0, 0.0), Action("turn", 1.0, 0.0, 1.0)),
        (Action("ahead", 1.0, 0.0), Action("left", 1.0, 0.4), Action("right", 1.0, -0.5)),
    ],
)
def test_a_body_without_a_lattice_has_no_oracle(actions):
    contender = Contender("odd", BlindPolicy(), PolicyContract(actions=actions))
    with pytest.raises(UsageError, match="limits: expected"):
        oracle_sums(contender, CELL, SUITE, Setting.FIELD)


def test_a_world_whose_obstacles_stop_nobody_has_no_oracle():
    with pytest.raises(UsageError, match="got ghosts"):
        oracle_sums(contender_of(BLIND), SuiteCell("x", "ghost"), SUITE, Setting.FIELD)
