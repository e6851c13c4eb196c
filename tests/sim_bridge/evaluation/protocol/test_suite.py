"""Suites as files."""

import math
from pathlib import Path

import pytest

from reflexarc_runtime.errors import ReflexarcError
from reflexarc_sim_bridge.evaluation.protocol.suite import SuiteCell, suite_named
from support.small_suite import SUITE


def test_lite_asks_nothing_that_full_does_not() -> None:
    lite, full = (
        {(family.name, cell.tier) for family, cell in suite_named(name).cells}
        for name in ("lite", "full")
    )
    assert lite < full


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
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


@pytest.mark.parametrize("name", ["clutter", "free_path_m"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_a_cell_of_no_size_is_refused_before_anything_is_driven(name: str, value: float) -> None:
    with pytest.raises(ReflexarcError, match=f"{name}: expected in"):
        SuiteCell("t", "reference-1", **{name: value})
