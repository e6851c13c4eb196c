"""Suites as files."""

from pathlib import Path

import pytest

from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.worlds.files import world_named
from support.small_suite import SUITE


@pytest.mark.parametrize("name", ["lite", "full"])
def test_shipped_suites_perturb_the_reference_field_and_nothing_else(name: str) -> None:
    suite = suite_named(name)
    worlds = {f"{family.name}/{cell.tier}": cell.world for family, cell in suite.cells}
    perturbed = [cell for _, cell in suite.cells if cell.perturbs]
    assert len(perturbed) == 7
    field = world_named("reference-1").drawn(0)
    for cell in perturbed:
        assert worlds[cell.perturbs] == "reference-1"
        assert cell.source.drawn(0).clutter() == pytest.approx(field.clutter())


def test_lite_asks_nothing_that_full_does_not() -> None:
    lite, full = (
        {(family.name, cell.tier) for family, cell in suite_named(name).cells}
        for name in ("lite", "full")
    )
    assert lite < full


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('perturbs = "rectangles/reference"', 'perturbs = "a/b"', "a cell of the suite"),
        ("worlds = 3", "worlds = 0", "1 to 4096"),
        ('name = "senses"', 'name = "rectangles"', "distinct names"),
        ("lanes = 2", "lane = 2", "lane"),
    ],
)
def test_what_no_suite_can_be_is_refused(
    before: str, after: str, said: str, tmp_path: Path
) -> None:
    path = tmp_path / "bad.toml"
    path.write_text(SUITE.replace(before, after))
    with pytest.raises(ReflexarcError, match=said):
        suite_named(str(path))
