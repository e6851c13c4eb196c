"""The published table: its two parts come from two runs, and neither undoes the other."""

import importlib.util
import json
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.protocol.results import (
    CellFacts,
    ResultRow,
    Results,
    plain_sums,
)
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from support.hand_tracks import track_of
from support.page_results import WORLDS, page_results

SCRIPT = Path(__file__).parents[2] / "docs" / "standing_page.py"
HOME = CellFacts("home", "bees", "bees", None, False)


@pytest.fixture
def script(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    spec = importlib.util.spec_from_file_location("standing_page", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    monkeypatch.syspath_prepend(str(SCRIPT.parent))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    (tmp_path / "figures").mkdir()
    monkeypatch.setattr(module, "PAGE", tmp_path / "standing.md")
    return module


def whole(row: ResultRow) -> ResultRow:
    """With every sum that figures ask for: made-up rows have those of the page alone."""
    all_sums = plain_sums(sums_of(track_of(10)))
    every = {name: values * WORLDS for name, values in all_sums.items()}
    return replace(row, sums={**every, **row.sums})


def saved(path: Path, results: Results) -> Path:
    rows, limits = ([whole(row) for row in part] for part in (results.rows, results.limits))
    path.write_text(json.dumps(replace(results, rows=rows, limits=limits).to_json()))
    return path


def at_home(results: Results, contacts: float, blind: float) -> Results:
    """With one cell of the home world more: so many contacts over 100 m, of each and of blind."""

    def moved(row: ResultRow, count: float) -> ResultRow:
        metres = [100.0] * WORLDS
        sums = {**row.sums, "contacts": [count] * WORLDS, "progress_m": metres, "way_m": metres}
        return replace(row, family=HOME.family, tier=HOME.tier, sums=sums)

    first = {row.contender: row for row in results.rows}
    limits = {row.contender: row for row in results.limits}
    return replace(
        results,
        rows=[*results.rows, *(moved(row, contacts) for row in first.values())],
        limits=[*results.limits, *(moved(row, blind) for row in limits.values())],
        cells=[*results.cells, HOME],
    )


def test_each_run_writes_its_part_and_keeps_the_other(script: ModuleType, tmp_path: Path) -> None:
    everybody = saved(tmp_path / "everybody.json", page_results(["reflex-0", "random"]))
    flow = saved(tmp_path / "flow.json", page_results(["flow-balance"]))
    script.main(everybody)
    alone = script.PAGE.read_text()
    assert "flow" not in alone
    script.main(flow, is_flow=True)
    both = script.PAGE.read_text()
    assert both.startswith(alone)
    assert both.count("flow-balance") == 4  # in each setting among the places, and by family
    script.main(everybody)
    assert script.PAGE.read_text() == both
    script.main(flow, is_flow=True)
    assert script.PAGE.read_text() == both


def test_at_home_stand_its_own_contacts_and_those_of_who_never_steers(
    script: ModuleType, tmp_path: Path
) -> None:
    results = at_home(page_results(["flow-largest"]), contacts=3.0, blind=5.0)
    script.main(saved(tmp_path / "flow.json", results), is_flow=True)
    rows = [line for line in script.PAGE.read_text().splitlines() if line.startswith("| 1 |")]
    assert sum(row.endswith("| 3.00, 5.00 |") for row in rows) == 1  # the field's, which was there


def test_at_equal_eyes_each_kind_is_ranked_by_itself_and_ours_is_compared_with_its_best(
    script: ModuleType, tmp_path: Path
) -> None:
    """Made-up contenders: each makes more contacts than the one before, in every world."""
    names = ["metres", "ppo-0", "reflex-0", "dqn-0", "far"]
    results = page_results(names, settings=[Setting.FIELD])
    metres, *others, far = results.agents
    agents = [replace(metres, eye=f"{metres.eye}, ranges"), *others]
    agents.append(replace(far, eye=far.eye.replace("range_m=5", "range_m=9")))
    script.main(saved(tmp_path / "results.json", replace(results, agents=agents)))
    section = script.PAGE.read_text().partition("### At equal eyes")[2]
    ranked = [line.split("`")[1] for line in section.splitlines() if line.count("`") == 2]
    assert ranked == ["ppo-0", "reflex-0", "dqn-0", "metres"]
    [everything] = [line.split(" | ") for line in section.splitlines() if line[:5] == "| all"]
    contacts = np.linspace(0.05, 1.1, len(names))[:3]  # shares of blind's; the oracle has 0.02
    expected = (contacts[:2] - contacts[2]) / (1.0 - 0.02)
    shown = [float(words.split()[0]) for words in everything[2:]]
    assert shown == pytest.approx(expected[::-1], abs=0.02)  # contacts are whole numbers
    assert "Against `ppo-0` it is better in none and worse in discs, motion" in section
