"""Which policy a replay asks: the one that the log carries, or another one that it is given."""

from pathlib import Path

from reflexarc_logs.reading.reader import Log
from reflexarc_runtime.errors import LogError, ReflexarcError
from reflexarc_runtime.loop.trials.tried_policy import load_tried_policy
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy
from reflexarc_runtime.words.suggestion import pasteable


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


def asked_policy(
    log: Log, given: LoadedPolicy | Path | str | None, backend: Backend | str | None
) -> LoadedPolicy:
    """The policy that is given, or else the one that the log carries.

    Raises:
        LogError: it carries none, or not the one that it names.
        PolicyError, ContractError: the policy is not intact.
    """
    if given is None:
        return attached_policy(log, backend)
    if not isinstance(given, LoadedPolicy):
        return load_tried_policy(given, backend or log.run.replay_backend)
    if backend is None or given.backend == Backend(backend):
        return given
    return load_tried_policy(given.data, backend)


def _check_identity(log: Log) -> None:
    if policy_hash(log.policy or b"") != log.run.policy_hash:
        command = pasteable("reflexarc", "replay", log.path, "--policy", "POLICY.onnx")
        raise LogError(
            f"{log.path}: the attached policy is not the one that the log names "
            f"({log.run.policy_hash[:12]}…); could not compare: get the log as it was recorded, or "
            f"say which policy is meant: `{command}`"
        )
