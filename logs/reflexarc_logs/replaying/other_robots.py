"""The other robots of a merged log: each as if the log were its own, as far as the log tells.

Where the log says how that robot's loop ran, it replays at both levels. Where it does not, its
ticks still name their policy, and are compared at level `policy`, to that contract's tolerance.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from mcap.records import Metadata

from reflexarc_logs.container.run_info import RUN, UNKNOWN_BACKEND, RunInfo
from reflexarc_logs.container.writing import ATTACHED_BESIDE, POLICY_ATTACHMENT
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.asked_policy import attached_policy
from reflexarc_logs.replaying.log_account import LogAccount
from reflexarc_logs.replaying.robot_replay import Level, RobotFindings, replay_robot, rules_for
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_runtime.errors import LogError, ReflexarcError
from reflexarc_runtime.messages.topics import TICK
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import LoadedPolicy

MOST_ROBOTS = 16
"""Each takes passes of its own over the file."""


@dataclass(frozen=True)
class _Told:
    """What a merged log says of its robots."""

    runs: Mapping[str, RunInfo]
    """By the robot's name."""
    policies: Mapping[str, bytes]
    """By their hash."""


def replay_others(
    account: LogAccount, policy: LoadedPolicy, level: Level | None, *, is_candidate: bool
) -> Iterator[RobotFindings]:
    """Replay every robot of a log but the one that it names.

    Args:
        account: of the log, filled.
        policy: whom the first robot's replay asked.
        level: policy or node; all that the log supports if None.
        is_candidate: whether every robot is compared with that policy, as it was given.
    """
    counts = _ticks_of_others(account)
    if not counts:
        return
    own = account.log.run.robot
    if not account.ticks_seen:
        yield RobotFindings([], notes=[f"{own}: it has no ticks"])
    told = _told(account.log)
    for number, (robot, ticks) in enumerate(sorted(counts.items())):
        try:
            if number >= MOST_ROBOTS:
                raise LogError(f"more than {MOST_ROBOTS} robots")
            view = _as_log_of(account.log, robot, told)
            asked = policy if is_candidate else _policy_of(view, policy)
            yield _replayed(view, asked, level, knows_run=robot in told.runs)
        except ReflexarcError as error:
            yield RobotFindings([], notes=[f"{robot}: {ticks} ticks were not compared: {error}"])


def _ticks_of_others(account: LogAccount) -> dict[str, int]:
    """Ticks by robot."""
    own, ending = account.log.topic(TICK.name), f"/{TICK.name}"
    return {
        topic[1 : -len(ending)]: messages
        for (topic, schema), messages in account.streams.items()
        if schema == TICK.schema and topic.endswith(ending) and topic != own
    }


def _told(log: Log) -> _Told:
    runs: dict[str, RunInfo] = {}
    policies: dict[str, bytes] = {}
    for record in log.mcap_records():
        if isinstance(record, Metadata) and record.name == RUN:
            run = RunInfo.from_metadata(record.metadata)
            runs.setdefault(run.robot, run)
    for name, data in log.attachments.items():
        if name.partition("#")[0] == POLICY_ATTACHMENT:
            policies[policy_hash(data)] = data
    return _Told(runs, policies)


def _as_log_of(log: Log, robot: str, told: _Told) -> Log:
    """The log as if it had named this robot."""
    run = told.runs.get(robot)
    if run is None:
        run = replace(
            log.run, robot=robot, backend=UNKNOWN_BACKEND, recorded_by="record", policy_hash=""
        )
    view = replace(log, run=run, attachments={})
    named = run.policy_hash or next(view.ticks()).decision.policy_hash
    data = told.policies.get(named)
    beside = [name for name in log.attachments if name.startswith(ATTACHED_BESIDE)]
    attachments = {name: log.attachments[name] for name in beside}
    if data is not None:
        attachments[POLICY_ATTACHMENT] = data
    return replace(view, run=replace(run, policy_hash=named), attachments=attachments)


def _policy_of(view: Log, policy: LoadedPolicy) -> LoadedPolicy:
    if view.run.policy_hash == policy.policy_hash:
        return policy
    if view.policy is None:
        raise LogError(f"their policy ({view.run.policy_hash[:12]}) is not in the log")
    return attached_policy(view)


def _replayed(
    view: Log, policy: LoadedPolicy, level: Level | None, *, knows_run: bool
) -> RobotFindings:
    robot, reason = view.run.robot, "the log does not say how its loop ran"
    if level == "node" and not knows_run:
        raise LogError(reason)
    account = LogAccount(view, ServedPolicies(view, policy))
    possible: Level | None = level if knows_run else "policy"
    found = replay_robot(account, policy, rules_for(view, policy), possible, robot)
    if level is None and not knows_run:
        found.notes.append(f"level node was left out: {reason}")
    found.notes = [f"{robot}: {note}" for note in found.notes]
    return found
