"""Logs and policies that older versions wrote load and replay identically, for ever."""

from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.text import SEALED_SINCE
from reflexarc_runtime.policy.policy import load_policy

MUSEUM = Path(__file__).parents[1] / "golden" / "museum"
LOGS = sorted(MUSEUM.rglob("*.mcap"))
POLICIES = sorted(MUSEUM.rglob("*.onnx"))


def name(path: Path) -> str:
    return f"{path.parent.name}/{path.name}"


def test_nothing_was_taken_out_of_the_museum():
    assert [name(path) for path in (*LOGS, *POLICIES)] == [
        "rules-2/faults.mcap",
        "rules-2/nominal.mcap",
        "rules-3/drive.mcap",
        "rules-3/faults.mcap",
        "rules-3/guarded-scan.mcap",
        "rules-3/nominal.mcap",
        "rules-4/faults.mcap",
        "rules-4/nominal.mcap",
        "rules-4/swapped.mcap",
        "schema-1/nominal.mcap",
        "schema-2/binocular-onnxruntime.mcap",
        "schema-2/drive.mcap",
        "schema-2/faults-live.mcap",
        "schema-2/faults.mcap",
        "schema-2/listener.mcap",
        "schema-2/nominal.mcap",
        "schema-2/rover-lockstep.mcap",
        "schema-2/scan.mcap",
        "schema-3/faults.mcap",
        "schema-3/nominal.mcap",
        "schema-4/faults.mcap",
        "schema-4/nominal.mcap",
        "schema-1/nominal.onnx",
        "schema-2/reflex.onnx",
        "schema-2/rover.onnx",
        "schema-3/reflex.onnx",
    ]


@pytest.mark.parametrize("path", LOGS, ids=name)
def test_an_old_log_replays_identically(path: Path):
    report = replay(path)
    assert report.verdict == "identical"
    levels = ["policy"] if path.stem == "listener" else ["policy", "node"]
    assert [level.level for level in report.levels] == levels
    assert all(level.compared > 0 for level in report.levels)
    kind, _, version = path.parent.name.partition("-")
    of_schemas = {"1": 1, "2": 1, "3": 4, "4": 4}
    assert read_log(path).run.rules == (int(version) if kind == "rules" else of_schemas[version])


@pytest.mark.parametrize("path", POLICIES, ids=name)
@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_an_old_policy_loads_and_is_noted_to_have_no_digest(path: Path, backend: str):
    policy = load_policy(path, backend)
    schema = path.parent.name.removeprefix("schema-")
    noted = [f"its contract is of schema {schema}"] if int(schema) < SEALED_SINCE else []
    assert [note.partition(",")[0] for note in policy.notes] == noted
    assert policy.contract.least_lead == 0.0
    assert policy.contract.recovery_inputs == 3
    assert (policy.contract.hold_s, policy.contract.margin, policy.contract.state.size) == (0, 0, 0)
