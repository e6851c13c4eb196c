"""A GRU and an LSTM out of torch, over Zenoh at 50 Hz: killed, recovered, replayed identically."""

import signal
import time
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.recurrent_network import GruNetwork, LstmNetwork
from support.processes import said_line, started

HIDDEN = 8
SECONDS = 2.5


@pytest.fixture(scope="module", params=[GruNetwork, LstmNetwork])
def policy(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An exported network of random weights."""
    path: Path = tmp_path_factory.mktemp("memory") / "policy.onnx"
    contract = replace(PolicyContract(), state=request.param.memory(HIDDEN))
    export(request.param(contract, hidden=HIDDEN, seed=4), contract, path)
    return path


def killed_drive(policy: Path, port: int, log: Path, backend: str) -> Log:
    """What is saved of a drive whose runtime was killed."""
    words = ("run", policy, "--port", port, "--record", log, "--backend", backend)
    with (
        started("sim", "--port", port, "--policy", policy, "--faults", "seed:3"),
        started(*words) as runtime,
    ):
        said_line(runtime, "reflexarc run:")
        time.sleep(SECONDS)
        runtime.send_signal(signal.SIGKILL)
        runtime.wait()
    fixed = log.with_name("fixed.mcap")
    recover(log.with_name(log.name + ".partial"), fixed)
    return read_log(fixed)


@pytest.mark.long
@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_a_killed_drive_of_a_policy_with_a_memory_replays(backend, policy, port, tmp_path):
    log = killed_drive(policy, port, tmp_path / "log.mcap", backend)
    asked = [t.decision for t in log.ticks() if t.decision.q_values]
    assert len(asked) > 50
    assert {len(decision.state) for decision in asked} == {load_policy(policy).contract.state.size}
    for other in ("numpy", "onnxruntime"):  # both backends agree on what either recorded
        report = replay(log, backend=other)
        assert report.exit_status == 0, report.lines()
        assert [level.level for level in report.levels] == ["policy", "node"]


def test_the_batch_from_recorded_memories_is_the_sequence(policy, port, tmp_path):
    log = killed_drive(policy, port, tmp_path / "log.mcap", "numpy")
    loaded = load_policy(policy)
    asked = [t.decision for t in log.ticks() if t.decision.q_values]
    stacks = np.array([np.frombuffer(d.retina, np.uint8) for d in asked])
    stacks = stacks.reshape(len(asked), *loaded.contract.retina.stack_shape)
    memories = np.array([d.state for d in asked], np.float32)
    q_values, _, following = loaded.decide(stacks, memories)
    recorded = np.array([d.q_values for d in asked], np.float32)
    assert q_values.tobytes() == recorded.tobytes()
    for before, (one, other) in enumerate(pairwise(asked)):
        if other.index == one.index + 1:  # no fault in between
            is_repeated = other.input.sequence == one.input.sequence
            expected = memories[before] if is_repeated else following[before]
            assert memories[before + 1].tobytes() == expected.tobytes()


def test_a_candidate_with_a_memory_is_judged_in_order_after_it_has_warmed_up(policy):
    drive = Path(__file__).parents[1] / "golden" / "museum" / "schema-2" / "drive.mcap"
    (level,) = replay(drive, policy=policy, level="policy").levels
    assert 90 <= level.warming_up <= 101  # two seconds at 50 Hz
    assert level.compared + level.warming_up >= 170
    again = replay(drive, policy=policy, level="policy")
    assert again.levels == (level,)
