"""The suite from Python."""

import json
from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.contender import contender_of
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.running.evaluate import evaluate
from support.small_suite import write_small_suite

FIELD = (Setting.FIELD,)


def test_texts_and_objects_are_measured_alike_and_written_down(tmp_path: Path) -> None:
    suite, controllers = write_small_suite(tmp_path)
    text = f"{controllers}:Mine"
    one, two = contender_of(text).policy, contender_of(text).policy
    out = tmp_path / "out"
    results = evaluate([text, one, two], str(suite), settings=FIELD, out=out)
    assert [agent.name for agent in results.agents] == [text, "Mine", "Mine 2"]
    sums = {
        agent.name: [row.sums for row in results.rows if row.contender == agent.name]
        for agent in results.agents
    }
    assert sums[text] == sums["Mine"] == sums["Mine 2"]
    document = json.loads((out / "results.json").read_text())
    assert Results.from_json(document) == results
    assert [card["name"] for card in document["scores"]] == [text, "Mine", "Mine 2"]
    times = json.loads((out / "times.json").read_text())
    assert set(times) == set(sums)
    assert all(each["p50_us"] > 0.0 for each in times.values())


def test_one_policy_is_enough(tmp_path: Path) -> None:
    suite, controllers = write_small_suite(tmp_path)
    mine = contender_of(f"{controllers}:Mine").policy
    results = evaluate(mine, str(suite), families=["senses"], settings=FIELD, rate_hz=25.0)
    assert [row.family for row in results.rows] == ["senses"]
    assert results.agents[0].rate_hz == 25.0


def test_what_is_no_policy_is_refused(tmp_path: Path) -> None:
    suite, _ = write_small_suite(tmp_path)
    with pytest.raises(UsageError, match="`contract` and `decide`, got int"):
        evaluate([3], str(suite))
