import math

import pytest

from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.evaluation.protocol.contender import contender_of
from reflexarc_sim_bridge.evaluation.protocol.perturbation import Perturbation, perturbed
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.world import Chassis, Senses, World


def test_by_default_nothing_is_worse() -> None:
    world = world_named("noisy")
    assert perturbed(world, Perturbation()) == world


def test_what_a_world_has_already_stays() -> None:
    senses = Senses(noise=0.03, dropout=0.5, latency_s=0.2)
    world = World("w", senses=senses, chassis=Chassis(slip=0.3))
    worse = perturbed(world, Perturbation(noise=0.04, dropout=0.5, latency_s=0.3, slip=0.4))
    assert worse.senses.noise == pytest.approx(0.05)
    assert worse.senses.dropout == pytest.approx(0.75)
    assert worse.senses.latency_s == pytest.approx(0.5)
    assert worse.chassis.slip == pytest.approx(0.5)


@pytest.mark.parametrize(("setting", "steps"), [(Setting.FIELD, 3), (Setting.ROBOT, 15)])
def test_a_delay_is_as_long_at_the_rate_of_a_robot(setting: Setting, steps: int) -> None:
    late = worlds_for(world_named("late"), contender_of("blind"), setting).drawn(0)
    assert (late.latency_steps, late.latency_steps * late.dt_s) == (steps, pytest.approx(0.3))
    seldom = worlds_for(world_named("seldom"), contender_of("blind"), setting).drawn(0)
    assert seldom.gap_steps * seldom.dt_s == pytest.approx(0.4)


def test_a_family_of_worlds_cannot_be_made_worse() -> None:
    with pytest.raises(ReflexarcError, match="family"):
        perturbed(world_named("randomised"), Perturbation(noise=0.1))


@pytest.mark.parametrize("wrong", [{"noise": -0.1}, {"slip": 1.1}, {"latency_s": math.nan}])
def test_what_no_world_can_have_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ReflexarcError):
        Perturbation(**wrong)


def test_the_grid_of_the_full_suite_is_the_same_world_made_worse_one_by_one() -> None:
    family = suite_named("full").only(("robustness",)).families[0]
    nominal, *worse = family.cells
    assert (nominal.tier, nominal.perturbation) == ("none", None)
    assert len({cell.perturbation for cell in worse}) == len(worse) == 12
    for cell in family.cells:
        assert not cell.counts
        assert (cell.world, cell.clutter) == ("reference-1", 0.1)
        assert cell.source.layers == nominal.source.layers
