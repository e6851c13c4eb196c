"""Replays a log through the policy and the controller, without bus and clock.

Two levels check each other. `policy`: the retina of each tick goes through the policy. `node`: the
messages that arrived go through the whole controller; it needs the log of a loop (`run --record`).
Beside them each recorded command is compared with its tick. What is not compared is said.
"""

from pathlib import Path
from typing import get_args

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.asked_policy import asked_policy
from reflexarc_logs.replaying.log_account import LogAccount
from reflexarc_logs.replaying.other_robots import replay_others
from reflexarc_logs.replaying.report import ReplayReport
from reflexarc_logs.replaying.robot_replay import Level, merged, replay_robot, rules_for
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.stream_uses import stream_uses
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy


def replay(
    log: Log | Path | str,
    *,
    policy: LoadedPolicy | Path | str | None = None,
    level: Level | None = None,
    backend: Backend | str | None = None,
) -> ReplayReport:
    """Replay a log and compare every tick with what was recorded.

    Args:
        log: the log, or its path.
        policy: another policy than the one attached to the log, or the path of one.
        level: policy or node; all that the log supports if None.
        backend: what shall compute the policy; as recorded if None.

    Raises:
        LogError: the log cannot be read, or does not support this level.
        PolicyError, ContractError: the policy is not intact.
        UsageError: no such level.
    """
    if level is not None and level not in get_args(Level):
        raise UsageError(f"--level: expected policy or node, got {level!r}")
    source = log if isinstance(log, Log) else read_log(Path(log))
    chosen = asked_policy(source, policy, backend)
    source.tick_descriptor()  # a log without ticks says so before any level begins
    rules = rules_for(source, chosen)
    account = LogAccount(source, ServedPolicies(source, chosen))
    found = replay_robot(account, chosen, rules, level)
    others = replay_others(account, chosen, level, is_candidate=policy is not None)
    notes = [] if source.complete else ["the log is truncated: its intact part was replayed"]
    found = merged([found, *others])
    return ReplayReport(
        log=str(source.path),
        policy_hash=chosen.policy_hash,
        same_policy=rules.same_policy,
        recorded_backend=source.run.backend,
        backend=chosen.backend.value,
        actions=tuple(action.name for action in chosen.contract.actions),
        levels=tuple(found.levels),
        notes=(*notes, *found.notes),
        commands=tuple(found.commands),
        streams=tuple(stream_uses(account, found)),
    )
