from dataclasses import replace

import pytest

from reflexarc_runtime.contract.eye import Shading
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.protocol.contender import contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, without_colours
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.layers import WHITE, Corridor
from reflexarc_sim_bridge.worlds.world import World

SUITES = ["lite", "full"]


@pytest.mark.parametrize("name", SUITES)
def test_the_home_of_flow_stands_beside_the_headline(name: str) -> None:
    (home,) = suite_named(name).only(("home",)).families
    assert [cell.tier for cell in home.cells] == ["bees", "bees-posts"]
    assert not any(cell.counts for cell in home.cells)
    beside = "home", "robustness"
    others = [family for family in suite_named(name).families if family.name not in beside]
    assert all(any(cell.counts for cell in family.cells) for family in others)


@pytest.mark.parametrize("tier", [0, 1])
def test_who_sees_nearness_in_one_frame_can_drive_there(tier: int) -> None:
    suite = replace(suite_named("lite").only(("home",)), worlds=2, lanes=2, free_paths=4.0)
    contender = contender_of("random")
    assert contender.contract.retina.shading is Shading.NEARNESS
    track = drive(contender, suite.families[0].cells[tier], suite, Setting.FIELD)
    assert track.met.shape == (200, 4)  # 4 x 5 m at 1 m/s and 10 Hz
    assert track.progress_m.sum() == pytest.approx(4 * 20.0, rel=0.05)


def test_a_range_finder_sees_neither_stripes_nor_contrasts() -> None:
    bees = world_named("bees")
    assert isinstance(bees, World)
    (walls,) = bees.layers
    assert isinstance(walls, Corridor)
    faint = replace(walls, left_contrast=0.5, right_contrast=0.2, left_wall_mps=0.3)
    (seen,) = without_colours(replace(bees, layers=(faint,))).layers
    assert seen == replace(walls, stripes_m=0.0, colour=WHITE)
