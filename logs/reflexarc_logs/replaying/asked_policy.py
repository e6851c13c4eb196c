"""Which policy a replay asks: the one that the log carries, or another one that it is given."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from reflexarc_logs.reading.reader import Log
from reflexarc_runtime.errors import LogError, PolicyError, ReflexarcError
from reflexarc_runtime.loop.trials.trial import Trial
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy, load_policy


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
        return _loaded(log.policy, backend or log.run.replay_backend)
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
        return _loaded(given, backend or log.run.replay_backend)
    if backend is None or given.backend == Backend(backend):
        return given
    return _loaded(given.data, backend)


def _loaded(source: Path | str | bytes, backend: Backend | str) -> LoadedPolicy:
    """Load a policy; for onnxruntime, whose graphs may loop, after a process of its own has."""
    if Backend(backend) is Backend.ONNXRUNTIME:
        _try(source)
    return load_policy(source, backend, bounds=None)


def _try(source: Path | str | bytes) -> None:
    with _policy_file(source) as path, Trial(path, Backend.ONNXRUNTIME.value) as trial:
        try:
            trial.finding()
        except PolicyError as error:
            name = "policy" if isinstance(source, bytes) else str(source)
            raise PolicyError(str(error).replace(str(path), name)) from None


@contextmanager
def _policy_file(source: Path | str | bytes) -> Iterator[Path]:
    """The file of a policy; a temporary one, if only its bytes are there."""
    if not isinstance(source, bytes):
        yield Path(source)
        return
    with TemporaryDirectory() as folder:
        path = Path(folder) / "policy.onnx"
        path.write_bytes(source)
        yield path


def _check_identity(log: Log) -> None:
    if policy_hash(log.policy or b"") != log.run.policy_hash:
        raise LogError(
            f"{log.path}: the attached policy is not the one that the log names "
            f"({log.run.policy_hash[:12]}…); could not compare"
        )
