"""The golden logs are what their builder makes; that they replay is the plugin's to test."""

import importlib.util
from collections import Counter
from itertools import pairwise
from pathlib import Path
from types import ModuleType

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.decision import Verdict

GOLDEN = Path(__file__).parents[1] / "golden"
LOGS = sorted(GOLDEN.glob("*.mcap"))


def builder() -> ModuleType:
    spec = importlib.util.spec_from_file_location("golden_build", GOLDEN / "build.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def verdicts(path: Path) -> Counter[str]:
    return Counter(Verdict(tick.decision.verdict).name for tick in read_log(path).ticks())


def test_there_are_two_golden_logs_and_they_are_small():
    assert [path.name for path in LOGS] == ["faults.mcap", "nominal.mcap"]
    assert all(path.stat().st_size < 200_000 for path in LOGS)


@pytest.mark.parametrize("path", LOGS, ids=lambda path: path.stem)
def test_a_golden_log_replays_identically_at_both_levels(path):
    report = replay(path)
    assert report.exit_status == 0
    assert [level.level for level in report.levels] == ["policy", "node"]
    assert all(level.compared > 200 for level in report.levels)


def test_the_nominal_log_drives_with_every_action():
    path = GOLDEN / "nominal.mcap"
    assert verdicts(path) == {"OK": 298, "RECOVERING": 2, "STOPPED": 1}
    actions = {tick.decision.action for tick in read_log(path).ticks()}
    assert actions == {-1, 0, 1, 2}


def test_every_verdict_but_a_policy_fault_occurs_among_the_faults():
    path = GOLDEN / "faults.mcap"
    everything = {verdict.name for verdict in Verdict if verdict <= Verdict.STOPPED} - {
        "POLICY_FAULT"
    }
    assert set(verdicts(path)) == everything
    reasons = {tick.decision.reason.partition(":")[0] for tick in read_log(path).ticks()}
    assert reasons >= {"payload", "encoding", "attachment", "retina"}
    assert [t.messages for t in summarise(path).topics if t.topic == "/robot0/rejected"] == [6]


def test_the_loop_of_the_faults_skips_slots_and_drains_several_inputs_at_once():
    ticks = [tick.decision for tick in read_log(GOLDEN / "faults.mcap").ticks()]
    gaps = {b.slot - a.slot for a, b in pairwise(ticks)}
    assert gaps >= {1, 3}
    assert max(tick.inputs for tick in ticks) >= 4


def test_the_golden_logs_are_rebuilt_record_for_record(tmp_path):
    builder().build(tmp_path)
    for path in LOGS:
        old, new = read_log(path), read_log(tmp_path / path.name)
        assert list(new.records()) == list(old.records())
        assert new.run == old.run
        assert new.attachments == old.attachments
