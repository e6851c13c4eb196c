"""A policy on the sensors of a log decides as the loop would have."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.deciding.decide import decide
from reflexarc_logs.importing.lidar_import import import_log
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import LogError, ReflexarcError, UsageError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.policy.policy import load_policy
from support.lidar import flaser
from support.policies import exported
from support.processes import reflexarc
from support.recordings import CONTRACT, FAULT_STALLS, drive, faults, nominal
from support.remembering import remembering_policy
from support.staged_incidents import contact, mark, staged, stopped_between

TICKS = 300


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("drives") / "drive.mcap"
    drive(path, exported(CONTRACT, 3, "Relu"), nominal(TICKS), TICKS)
    return path


@pytest.fixture(scope="module")
def log(path: Path) -> Log:
    return read_log(path)


def test_the_same_policy_decides_the_same(log: Log, tmp_path: Path):
    decided = decide(log, load_policy(log.policy or b""), tmp_path / "again.mcap")
    again, before = (_by_input(one) for one in (read_log(decided.path), log))
    assert len(before) > TICKS - 5
    assert before.items() <= again.items()  # the former run ended with an input it did not use


def test_a_policy_that_was_never_asked_is_said_with_the_reason(log: Log, tmp_path: Path):
    eye = dataclasses.replace(CONTRACT.retina, fov_rad=2.0)
    blind = exported(dataclasses.replace(CONTRACT, retina=eye), 4)
    decided = decide(log, load_policy(blind), tmp_path / "blind.mcap")
    assert "OK" not in decided.verdicts
    assert "fov" in decided.why_nothing
    assert not decide(log, load_policy(exported(CONTRACT, 9)), tmp_path / "b.mcap").why_nothing


def _by_input(log: Log) -> dict[int, tuple[object, ...]]:
    """What the policy was given and said, by the number of the input."""
    return {
        d.input.sequence: (d.retina, tuple(d.q_values), d.action)
        for d in (tick.decision for tick in log.ticks())
        if d.q_values
    }


def test_every_tick_used_the_newest_input_that_had_arrived(log: Log, tmp_path: Path):
    """Against a slow account: arrivals from the log, the policy asked tick by tick."""
    policy = load_policy(exported(CONTRACT, 9, "Relu"))
    decided = decide(log, policy, tmp_path / "other.mcap")
    arrived = [
        (r.log_ns - log.run.wall_offset_ns, r.sequence) for r in log.records("/robot0/retina")
    ]
    asked = 0
    for tick in read_log(decided.path).ticks():
        decision = tick.decision
        if not decision.q_values:
            continue
        newest = max(sequence for at_ns, sequence in arrived if at_ns <= decision.now_ns)
        assert decision.input.sequence == newest
        retina = np.frombuffer(decision.retina, np.uint8).reshape(1, 1, 1, 16, 1)
        q_values, actions = policy.decide(retina)
        assert list(decision.q_values) == [float(q) for q in q_values[0]]
        assert decision.action == actions[0]
        asked += 1
    assert asked > TICKS - 5


@pytest.mark.parametrize("name", ["plain", "guarded", "memory"])
def test_what_was_decided_replays_at_both_levels(name: str, tmp_path: Path):
    source = tmp_path / "source.mcap"
    drive(source, exported(CONTRACT, 3), faults(TICKS), TICKS, stalls=FAULT_STALLS)
    data = remembering_policy() if name == "memory" else exported(CONTRACT, 4)
    policy = load_policy(data)
    guard = GuardSettings.of(policy.contract) if name == "guarded" else None
    decided = decide(read_log(source), policy, tmp_path / "out.mcap", guard=guard)
    report = replay(decided.path)
    assert report.exit_status == 0, report.lines()
    assert [level.level for level in report.levels] == ["policy", "node"]
    assert decided.ticks > TICKS - 10


def test_deciding_twice_gives_the_same_bytes(log: Log, tmp_path: Path):
    policy = load_policy(log.policy or b"")
    for name in ("a", "b"):
        decide(log, policy, tmp_path / f"{name}.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_what_was_heard_beside_stays_and_what_a_loop_did_does_not(path: Path, tmp_path: Path):
    source = staged(path, tmp_path / "staged.mcap", {50: contact(), 60: mark("odd")})
    log = read_log(source)
    decided = decide(log, load_policy(log.policy or b""), tmp_path / "out.mcap")
    topics = {record.topic for record in read_log(decided.path).records()}
    assert {"/robot0/contact", "/robot0/mark", "/robot0/retina"} <= topics
    assert decided.left_out["/robot0/tick"] == TICKS + 1


def test_stops_of_the_former_run_stop_nothing(tmp_path: Path):
    schedule = nominal(TICKS)
    stopped_between(schedule, 100, 200)
    source = tmp_path / "stopped.mcap"
    drive(source, exported(CONTRACT, 3), schedule, TICKS)
    log = read_log(source)
    decided = decide(log, load_policy(log.policy or b""), tmp_path / "out.mcap")
    assert decided.verdicts["STOPPED"] == 1  # its own end
    assert decided.left_out["/robot0/stop"] == 2


def test_a_lidar_log_of_another_system(tmp_path: Path):
    text = "".join(
        flaser(" ".join(["2.0"] * 180), time=f"{100 + number / 10:.2f}") for number in range(40)
    )
    (tmp_path / "room.log").write_text(text)
    import_log(tmp_path / "room.log", tmp_path / "room.mcap", "carmen")
    policy = load_policy(exported(PolicyContract()))
    decided = decide(read_log(tmp_path / "room.mcap"), policy, tmp_path / "out.mcap")
    assert decided.sensor == "scan"
    assert decided.verdicts["OK"] > 100  # 50 Hz on a scanner of 10 Hz, for four seconds
    assert replay(decided.path).exit_status == 0


def test_errors_name_what_is_missing(log: Log, tmp_path: Path):
    policy = load_policy(log.policy or b"")
    with pytest.raises(LogError, match="expected scans, found retinas only"):
        decide(log, policy, tmp_path / "o.mcap", sensor="scan")
    with pytest.raises(UsageError, match="expected retina or scan"):
        decide(log, policy, tmp_path / "o.mcap", sensor="sonar")
    blind = PolicyContract(retina=CONTRACT.retina)
    out = tmp_path / "there.mcap"
    out.write_bytes(b"mine")
    with pytest.raises(ReflexarcError, match="exists already"):
        decide(log, load_policy(exported(blind)), out)
    assert out.read_bytes() == b"mine"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["there.mcap"]


def test_the_command(path: Path, tmp_path: Path):
    (tmp_path / "new.onnx").write_bytes(exported(CONTRACT, 8))
    words = ("decide", path, "--policy", tmp_path / "new.onnx", "-o", tmp_path / "new.mcap")
    ended = reflexarc(*words, "--no-guard", "--json")
    assert ended.returncode == 0, ended.stderr
    said = json.loads(ended.stdout)
    assert (said["replay"], said["sensor"]) == ("identical", "retina")
    assert reflexarc(*words).returncode == 2
