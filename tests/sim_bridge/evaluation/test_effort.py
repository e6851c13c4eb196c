"""How much of a world is looked at: all of those that people use, less of those without measure."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation import cover_profile, fairness
from reflexarc_sim_bridge.evaluation.cover_profile import BINS, are_covered, columns_allowed
from reflexarc_sim_bridge.evaluation.effort import MOST_DRAWN, MOST_LOOKED_AT, effort_of
from reflexarc_sim_bridge.evaluation.fairness import check_world
from reflexarc_sim_bridge.simulation.covered_places import covered
from reflexarc_sim_bridge.worlds.files import WORLDS, world_named
from reflexarc_sim_bridge.worlds.layers import Automaton, Drift, Scatter
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.shapes import Rectangles
from reflexarc_sim_bridge.worlds.world import World

SMALL = (Rectangles(width_m=(0.1, 0.1), length_m=(0.1, 0.1)),)
WITHOUT_MEASURE = {
    "dense": World("x", width_m=1e4, layers=(Scatter(16.0, SMALL),)),
    "dense, on a belt": World("x", width_m=500.0, layers=(Scatter(16.0, SMALL),)),
    "thinned": World("x", width_m=1e4, layers=(Scatter(16.0, SMALL, gap_m=1.25),)),
    "automata": World("x", width_m=1e4, layers=(Automaton(16, 0.4, 4),) * 5),
    "fast": World("x", layers=(Scatter(16.0, SMALL, motion=Drift(left_mps=100.0)),) * 5),
}


@pytest.mark.parametrize("name", WITHOUT_MEASURE)
def test_work_is_bounded_whatever_a_world_is(name: str) -> None:
    world = WITHOUT_MEASURE[name]
    _, most = columns_allowed(world, 64)
    short = effort_of(world, cover_profile.short_sighted(), BINS)
    assert most == 1 or most * 64 * short.drawn_a_column <= MOST_DRAWN + 64 * short.drawn_a_column
    effort = effort_of(world, reference_contract(), BINS)
    agents = fairness.blind_agents([effort])
    assert agents == 64 or agents * 50 * effort.looked_at_a_step <= MOST_LOOKED_AT


def test_worlds_that_people_use_are_looked_at_as_before() -> None:
    fewer = {name for name, world in WORLDS.items() if columns_allowed(world, 64) != (64, 1024)}
    assert fewer <= {"automaton", "forest"}
    for world in WORLDS.values():
        efforts = [effort_of(one, reference_contract(), BINS) for one in world.fullest]
        assert min(effort.most_steps(0.024, 0.1) for effort in efforts) / 1024 >= 1000
        assert fairness.blind_agents(efforts) == 1024


def test_who_meets_more_or_enters_more_costs_more() -> None:
    effort = effort_of(WITHOUT_MEASURE["dense"], reference_contract(), BINS)
    assert effort.most_steps(0.5, 0.1) < effort.most_steps(0.1, 0.1) < effort.most_steps(0.1, 0.0)
    moving = effort_of(WITHOUT_MEASURE["fast"], reference_contract(), BINS)
    assert (effort.entered_a_step, moving.entered_a_step) == (pytest.approx(0.04), 1.0)


def test_ashort_sighted_agent_finds_the_same_places_covered() -> None:
    x_m, y_m = np.random.default_rng(1).uniform(0.0, 20.0, (2, 2000))
    world = world_named("crossing").drawn(0)
    pointlike = replace(world, chassis=replace(world.chassis, radius_m=0.0))
    far = covered(pointlike, reference_contract(), 3, np.stack([x_m, y_m], axis=1))
    assert are_covered(world, 3, x_m, y_m).tolist() == far.tolist()
    assert far.any()


def test_a_world_that_is_looked_at_less_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fairness, "_BLIND_STEPS", 2_000_000)
    report = check_world(World("empty", layers=(Scatter(16.0, SMALL),)), seeds=2)
    assert any("steps only, of 2000000" in note for note in report.notes)
