"""One robot's part of a log, replayed: both levels where it allows them, and its commands."""

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.comparison import EqualityRules
from reflexarc_logs.replaying.log_account import LogAccount
from reflexarc_logs.replaying.loop_events import NoLoopError
from reflexarc_logs.replaying.node_level import replay_node, why_not
from reflexarc_logs.replaying.policy_level import replay_policy
from reflexarc_logs.replaying.report import CommandsResult, LevelResult
from reflexarc_logs.replaying.serving.shadow_level import replay_shadows
from reflexarc_runtime.messages.topics import SHADOW
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy

Level: TypeAlias = Literal["policy", "node"]


@dataclass
class RobotFindings:
    """What the replay of one robot found, or of several."""

    robots: list[str]
    """Whose ticks and commands were compared."""
    levels: list[LevelResult] = field(default_factory=list)
    commands: list[CommandsResult] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    stepped: list[str] = field(default_factory=list)
    """Robots whose loop was replayed at level node."""
    shadowed: list[str] = field(default_factory=list)
    """Robots whose loop was watched by a policy that was asked again."""
    keyed: list[str] = field(default_factory=list)
    """Those among them whose keyframes were compared; another policy knows other things."""


def merged(findings: Iterable[RobotFindings]) -> RobotFindings:
    """The findings of several robots as one."""
    total = RobotFindings([])
    for found in findings:
        total.robots += found.robots
        total.levels += found.levels
        total.commands += found.commands
        total.notes += found.notes
        total.stepped += found.stepped
        total.shadowed += found.shadowed
        total.keyed += found.keyed
    return total


def rules_for(log: Log, policy: LoadedPolicy) -> EqualityRules:
    """What counts as equal when this policy is asked about this log."""
    return EqualityRules(
        exact=Backend.NUMPY == policy.backend == log.run.backend,
        same_policy=policy.policy_hash == log.run.policy_hash,
        tolerance=policy.contract.q_tolerance,
    )


def replay_robot(
    account: LogAccount,
    policy: LoadedPolicy,
    rules: EqualityRules,
    level: Level | None,
    other: str = "",
) -> RobotFindings:
    """Replay one robot's part of a log.

    Args:
        account: of that part; it is filled.
        policy: whom to ask.
        rules: what counts as equal.
        level: policy or node; all that the log supports if None.
        other: the robot's name, if it is not the one that the log names.

    Raises:
        LogError: the log cannot be read, or does not support this level.
    """
    log = account.log
    found = RobotFindings([log.run.robot])
    if level == "node":
        deque(account.runs(), maxlen=0)
    else:
        runs, served = account.runs(), account.served
        found.levels.append(replay_policy(log, policy, rules, runs, other, served))
    if level != "policy":
        try:
            _add_node_level(found, account, policy, rules, other)
        except NoLoopError as error:
            if level == "node":
                raise
            found.notes.append(f"level node was left out: {error.reason}")
    if level != "node":
        _add_shadows(found, account, rules, other)
    found.commands.append(account.commands())
    found.notes += account.notes()
    return found


def _add_shadows(
    found: RobotFindings, account: LogAccount, rules: EqualityRules, other: str
) -> None:
    log = account.log
    served = account.served
    if served is None or not account.streams[log.topic(SHADOW.name), SHADOW.schema]:
        return
    result, notes = replay_shadows(log, served, rules, other)
    found.notes += notes
    if result.compared:
        found.levels.append(result)
        found.shadowed.append(log.run.robot)


def _add_node_level(
    found: RobotFindings,
    account: LogAccount,
    policy: LoadedPolicy,
    rules: EqualityRules,
    other: str,
) -> None:
    log = account.log
    obstacle = why_not(log) or account.why_no_loop()
    if obstacle:
        raise NoLoopError(log, obstacle)
    result, notes = replay_node(log, policy, rules, other, account.served)
    found.levels.append(result)
    found.notes += notes
    if result.compared:
        found.stepped.append(log.run.robot)
        found.keyed += [log.run.robot] * rules.same_policy
