"""Ticks compared many at once against the same ticks one by one: the same report of any log."""

import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.columns import tick_runs
from reflexarc_logs.columns.tick_runs import TickRun
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.log_account import LogAccount
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.messages_pb2 import Decision, Tick
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported
from support.recordings import CONTRACT, RUN, drive, faults, nominal
from support.remembering import remembering_policy
from support.rewriting import Edit, flip_bit, rewrite

TICKS = 120
CONTRACTS = {
    "plain": CONTRACT,
    "held": replace(CONTRACT, hold_s=0.1, margin=0.05),
    "margin": replace(CONTRACT, margin=0.2),
}
NEVER = 1 << 30
"""Ticks of a run that no log has: all are taken one by one."""


@pytest.fixture(scope="module", params=CONTRACTS)
def log_path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("runs") / f"{request.param}.mcap"
    drive(path, exported(CONTRACTS[request.param], seed=3), nominal(TICKS), TICKS)
    return path


def judged(path: Path, policy: bytes | None, backend: str | None = None) -> str:
    """The report, or why there is none."""
    try:
        given = None if policy is None else load_policy(policy)
        report = replay(path, policy=given, level="policy", backend=backend)
        return str(report.as_dict())
    except ReflexarcError as error:
        return str(error)


def assert_same_one_by_one(
    path: Path, monkeypatch: pytest.MonkeyPatch, backend: str | None = None
) -> str:
    """For its own policy, and for another one."""
    policies = None, exported(CONTRACT, seed=9)
    together = [judged(path, policy, backend) for policy in policies]
    with monkeypatch.context() as patch:
        patch.setattr(tick_runs, "LEAST_TICKS", NEVER)
        assert [judged(path, policy, backend) for policy in policies] == together
    return together[0]


def in_runs(path: Path) -> int:
    """How many ticks of a log are taken together."""
    found = LogAccount(read_log(path)).runs()
    return sum(len(one) for one in found if isinstance(one, TickRun))


def test_nearly_all_ticks_of_a_drive_are_taken_together(log_path: Path) -> None:
    assert in_runs(log_path) >= TICKS - 5


def test_a_drive_is_judged_alike(log_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "'verdict': 'identical'" in assert_same_one_by_one(log_path, monkeypatch)


def test_a_drive_on_another_backend_is_judged_alike(
    log_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert_same_one_by_one(log_path, monkeypatch, backend="onnxruntime")


def test_a_drive_with_faults_is_judged_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "faults.mcap"
    drive(path, exported(CONTRACT), faults(300), 300)
    assert in_runs(path) > 100
    assert_same_one_by_one(path, monkeypatch)


def test_a_drive_of_a_policy_with_a_memory_is_judged_alike(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, policy = tmp_path / "memory.mcap", load_policy(remembering_policy())
    drive(path, policy, nominal(TICKS), TICKS, run=RUN)
    together = judged(path, None)
    monkeypatch.setattr(tick_runs, "LEAST_TICKS", NEVER)
    assert judged(path, None) == together


def _set(name: str, change: Callable[[Decision], object]) -> Callable[[Decision], None]:
    return lambda decision: setattr(decision, name, change(decision))


def _poison(decision: Decision) -> None:
    decision.q_values[0] = float("nan")


CHANGES: tuple[Callable[[Decision], None], ...] = (
    _set("index", lambda d: d.index + 1),
    _set("index", lambda d: max(d.index, 1) - 1),
    _set("slot", lambda d: d.slot + 3),
    _set("now_ns", lambda d: d.now_ns + 1),
    _set("action", lambda d: (d.action + 1) % 3),
    _set("action", lambda d: 7),
    _set("winner", lambda d: (d.winner + 1) % 3),
    _set("winner", lambda d: -1),
    _set("verdict", lambda d: 3),
    _set("reason", lambda d: "why"),
    _set("policy_hash", lambda d: "ab" * 32),
    _set("policy_hash", lambda d: ""),
    _set("retina", lambda d: bytes(len(d.retina))),
    _poison,
    lambda decision: decision.ClearField("command"),
    lambda decision: setattr(decision.command, "sequence", decision.command.sequence + 1),
)


@pytest.mark.parametrize("number", range(len(CHANGES)))
def test_a_changed_tick_is_judged_alike(
    log_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    def edit(topic: str, nth: int, payload: bytes) -> bytes:
        if not topic.endswith("/tick") or nth not in (40, 41, 77):
            return payload
        tick = Tick.FromString(payload)
        CHANGES[number](tick.decision)
        return tick.SerializeToString()

    changed = rewrite(log_path, tmp_path / "changed.mcap", edit)
    assert_same_one_by_one(changed, monkeypatch)


@pytest.mark.parametrize("seed", range(25))
def test_damage_and_loss_are_judged_alike(
    log_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, seed: int
) -> None:
    changed = rewrite(log_path, tmp_path / "changed.mcap", damage(seed))
    assert_same_one_by_one(changed, monkeypatch)


def damage(seed: int) -> Edit:
    """One bit of a tick or a command, or one that is lost."""
    draw = random.Random(seed)
    topic, at, is_lost = draw.choice(["/tick", "/command"]), draw.randrange(TICKS), seed % 5 == 0

    def edit(name: str, nth: int, payload: bytes) -> bytes | None:
        if not name.endswith(topic) or nth != at or not payload:
            return payload
        if is_lost:
            return None
        return flip_bit(payload, draw.randrange(len(payload)), draw.randrange(8))

    return edit
