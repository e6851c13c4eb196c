"""Blind agents in the suite's own cells: 2ρR contacts a metre wherever obstacles are unthinned."""

import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, RANDOM, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.worlds.world import World

SUITE = replace(suite_named("lite"), worlds=192, lanes=2)
CELLS = {
    f"{family.name} {cell.tier}": cell
    for family in SUITE.families
    for cell in family.cells
    if isinstance(cell.source, World) and cell.source.blind_contacts_per_100m is not None
}
UPRIGHT = "rectangles 0.05", "rectangles 0.20", "body wide"
AGAIN = 0.06
"""Round and turned things are met again beside the place where they were met: see `World`."""


def rate(source, cell, setting):
    sums = sums_of(drive(contender_of(source), cell, SUITE, setting))
    per_world = sums["contacts"] / sums["progress_m"]
    error = 100.0 * per_world.std(ddof=1) / math.sqrt(len(per_world))
    return 100.0 * sums["contacts"].sum() / sums["progress_m"].sum(), error


@pytest.mark.long
@pytest.mark.parametrize("name", [*UPRIGHT, "discs 0.10", "outlines stars"])
def test_a_blind_agent_meets_two_rho_r_obstacles_a_metre_in_cells_of_the_suite(name):
    cell = CELLS[name]
    measured, error = rate(BLIND, cell, Setting.FIELD)
    expected = cell.source.blind_contacts_per_100m
    assert error < 0.03 * expected
    excess = 0.0 if name in UPRIGHT else AGAIN
    assert measured < expected * (1.0 + excess) + 3.5 * error
    assert measured > expected - 3.5 * error


def test_drawn_motions_meet_as_much_as_none():
    # Sideways it goes, too: it meets what stands beside its way, and more of it than a blind one.
    cell = CELLS["rectangles 0.10"]
    (blind, error), (drawn, other) = (rate(who, cell, Setting.FIELD) for who in (BLIND, RANDOM))
    assert drawn > blind - 3.5 * np.hypot(error, other)
    assert drawn < 2.0 * blind
