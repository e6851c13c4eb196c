"""Replays a log through the policy and the controller, without bus and clock.

Two levels check each other. `policy`: the retina of each tick goes through the policy. `node`: the
messages that arrived go through the whole controller; it needs the log of a loop (`run --record`).
"""

from pathlib import Path
from typing import Literal, get_args

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.comparison import EqualityRules, LevelResult, ReplayReport
from reflexarc_logs.replaying.node_level import replay_node, why_not
from reflexarc_logs.replaying.policy_level import replay_policy
from reflexarc_runtime.errors import LogError, ReflexarcError, UsageError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy

Level = Literal["policy", "node"]


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
    source = log if isinstance(log, Log) else read_log(log)
    chosen = _policy(source, policy, backend)
    rules = EqualityRules(
        exact=Backend.NUMPY == chosen.backend == source.run.backend,
        same_policy=chosen.policy_hash == source.run.policy_hash,
        tolerance=chosen.contract.q_tolerance,
    )
    source.tick_descriptor()  # a log without ticks says so before any level begins
    results, notes = _run(source, chosen, rules, level)
    return ReplayReport(
        log=str(source.path),
        policy_hash=chosen.policy_hash,
        same_policy=rules.same_policy,
        recorded_backend=source.run.backend,
        backend=chosen.backend.value,
        actions=tuple(action.name for action in chosen.contract.actions),
        levels=tuple(results),
        notes=tuple(notes),
    )


def attached_policy(log: Log, backend: Backend | str | None = None) -> LoadedPolicy:
    """The policy that a log carries.

    Raises:
        LogError: it carries none, or not the one that it names.
        PolicyError, ContractError: the policy is not intact.
    """
    if log.policy is None:
        raise LogError(f"{log.path}: no policy is attached; give one with --policy")
    _check_identity(log)
    try:
        return load_tried_policy(log.policy, backend or log.run.replay_backend)
    except ReflexarcError as error:
        raise type(error)(f"{log.path}: attached {error}") from None


def _policy(
    log: Log, given: LoadedPolicy | Path | str | None, backend: Backend | str | None
) -> LoadedPolicy:
    if given is None:
        return attached_policy(log, backend)
    if not isinstance(given, LoadedPolicy):
        return load_tried_policy(given, backend or log.run.replay_backend)
    if backend is None or given.backend == Backend(backend):
        return given
    return load_tried_policy(given.data, backend)


def _check_identity(log: Log) -> None:
    if policy_hash(log.policy or b"") != log.run.policy_hash:
        raise LogError(
            f"{log.path}: the attached policy is not the one that the log names "
            f"({log.run.policy_hash[:12]}…); could not compare"
        )


def _run(
    log: Log, policy: LoadedPolicy, rules: EqualityRules, level: Level | None
) -> tuple[list[LevelResult], list[str]]:
    results: list[LevelResult] = []
    notes = [] if log.complete else ["the log is truncated: its intact part was replayed"]
    if level != "node":
        results.append(replay_policy(log, policy, rules))
    if level != "policy":
        obstacle = why_not(log)
        if obstacle and level == "node":
            raise LogError(f"{log.path}: no replay at level node: {obstacle}; use --level policy")
        if obstacle:
            notes.append(f"level node was left out: {obstacle}")
        else:
            result, told = replay_node(log, policy, rules)
            results.append(result)
            notes += told
    return results, notes
